// SPDX-License-Identifier: MIT
// Unpacks a cluster's positions, eight vertices at a time. Eight values of w bits are w bytes; a
// shuffle brings to each lane the three bytes that hold its value.
#if defined(__x86_64__)

#include "store/clusters/clusters_layout.h"

#include <assert.h>
#include <immintrin.h>

enum { GROUP = 8, GROUP_BYTES = 16 };

/// Byte positions of the values of a group.
typedef struct unpacking {
    __m256i bytes, shift, mask, origin;
    int left;
} unpacking;

static unpacking make_unpacking(const stp_cluster_run* run)
{
    assert(run->width <= CLUSTERS_UNPACK_WIDTH && run->shift < 32);
    __m256i bit = _mm256_mullo_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
                                     _mm256_set1_epi32((int)run->width));
    // each lane gets four bytes from its first one on; bytes past the end wrap around and are
    // masked off
    __m256i first = _mm256_mullo_epi32(_mm256_srli_epi32(bit, 3), _mm256_set1_epi32(0x01010101));
    __m256i bytes = _mm256_add_epi32(first, _mm256_set1_epi32(0x03020100));
    return (unpacking){
        .bytes = _mm256_and_si256(bytes, _mm256_set1_epi32(0x0F0F0F0F)),
        .shift = _mm256_and_si256(bit, _mm256_set1_epi32(7)),
        .mask = _mm256_set1_epi32((int)((1u << run->width) - 1)),
        .origin = _mm256_set1_epi32(run->origin),
        .left = run->shift,
    };
}

static inline __m256 unpack(const unpacking* u, const uint8_t* group, __m256 step)
{
    __m128i half = _mm_loadu_si128((const __m128i*)(const void*)group);
    __m256i words = _mm256_shuffle_epi8(_mm256_broadcastsi128_si256(half), u->bytes);
    __m256i value = _mm256_and_si256(_mm256_srlv_epi32(words, u->shift), u->mask);
    value = _mm256_add_epi32(_mm256_sll_epi32(value, _mm_cvtsi32_si128(u->left)), u->origin);
    return _mm256_mul_ps(_mm256_cvtepi32_ps(value), step);
}

/// Interleaves three numbers per vertex.
static inline void store_vertices(const __m256 axis[3], float* out)
{
    // place i of vector k is number 8 k + i: axis (8 k + i) mod 3 of vertex (8 k + i) / 3
    const __m256i from[3][3] = {
        {_mm256_setr_epi32(0, 0, 0, 1, 0, 0, 2, 0), _mm256_setr_epi32(0, 0, 0, 0, 1, 0, 0, 2),
         _mm256_setr_epi32(0, 0, 0, 0, 0, 1, 0, 0)},
        {_mm256_setr_epi32(0, 3, 0, 0, 4, 0, 0, 5), _mm256_setr_epi32(0, 0, 3, 0, 0, 4, 0, 0),
         _mm256_setr_epi32(2, 0, 0, 3, 0, 0, 4, 0)},
        {_mm256_setr_epi32(0, 0, 6, 0, 0, 7, 0, 0), _mm256_setr_epi32(5, 0, 0, 6, 0, 0, 7, 0),
         _mm256_setr_epi32(0, 5, 0, 0, 6, 0, 0, 7)},
    };
    __m256 x = _mm256_permutevar8x32_ps(axis[0], from[0][0]);
    __m256 y = _mm256_permutevar8x32_ps(axis[1], from[0][1]);
    __m256 z = _mm256_permutevar8x32_ps(axis[2], from[0][2]);
    _mm256_storeu_ps(out, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x92), z, 0x24));
    x = _mm256_permutevar8x32_ps(axis[0], from[1][0]);
    y = _mm256_permutevar8x32_ps(axis[1], from[1][1]);
    z = _mm256_permutevar8x32_ps(axis[2], from[1][2]);
    _mm256_storeu_ps(out + GROUP, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x24), z, 0x49));
    x = _mm256_permutevar8x32_ps(axis[0], from[2][0]);
    y = _mm256_permutevar8x32_ps(axis[1], from[2][1]);
    z = _mm256_permutevar8x32_ps(axis[2], from[2][2]);
    _mm256_storeu_ps(out + 2 * GROUP, _mm256_blend_ps(_mm256_blend_ps(x, y, 0x49), z, 0x92));
}

uint32_t stp_clusters_unpack_avx2(const stp_cluster_run runs[3], uint32_t count, float step,
                                  float* positions)
{
    static const uint8_t nothing[GROUP_BYTES];
    const uint8_t* bits[3];
    uint32_t end = count;
    for (int k = 0; k < 3; ++k) {
        uint32_t width = runs[k].width;
        if (runs[k].layout != STP_CLUSTER_PLAIN || width > CLUSTERS_UNPACK_WIDTH) {
            return 0;
        }
        bits[k] = width == 0 ? nothing : runs[k].bits;
        // a load reads all 16 bytes of a group: padding follows the run
        uint32_t bytes = (count * width + 7) / 8 + CLUSTERS_PADDING_BYTES;
        if (width != 0) {
            uint32_t groups = bytes < GROUP_BYTES ? 0 : (bytes - GROUP_BYTES) / width + 1;
            end = groups * GROUP < end ? groups * GROUP : end;
        }
    }
    const unpacking axes[3] = {make_unpacking(&runs[0]), make_unpacking(&runs[1]),
                               make_unpacking(&runs[2])};
    const __m256 steps = _mm256_set1_ps(step);
    uint32_t done = 0;
    for (uint32_t group = 0; done + GROUP <= end; ++group, done += GROUP) {
        __m256 axis[3];
        for (int k = 0; k < 3; ++k) {
            axis[k] = unpack(&axes[k], bits[k] + group * runs[k].width, steps);
        }
        store_vertices(axis, positions + 3 * (size_t)done);
    }
    assert(done <= count && done % GROUP == 0);
    return done;
}

#endif
