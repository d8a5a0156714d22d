// SPDX-License-Identifier: MIT
#include "lod/grid.h"

#if defined(__x86_64__)

#include "base/math/triples_avx2.h"

#include <assert.h>

enum { LANES = 8 };

// stp_grid_cell of eight coordinates.
static inline __m256i find_cells(const stp_grid* grid, __m256 coordinates)
{
    __m256 cell = _mm256_sub_ps(coordinates, _mm256_set1_ps(grid->offset));
    cell = _mm256_mul_ps(cell, _mm256_set1_ps(grid->inverse_cell));
    cell = _mm256_min_ps(_mm256_max_ps(cell, _mm256_set1_ps(-1e9f)), _mm256_set1_ps(1e9f));
    return _mm256_cvttps_epi32(_mm256_floor_ps(cell));
}

static inline __m256i multiply(__m256i a, uint32_t b)
{
    return _mm256_mullo_epi32(a, _mm256_set1_epi32((int)b));
}

// The lower two bits of eight cells, shifted.
static inline __m256i within_block(__m256i cell, int shift)
{
    return _mm256_slli_epi32(_mm256_and_si256(cell, _mm256_set1_epi32(3)), shift);
}

// stp_grid_bucket of eight cells.
static inline __m256i hash_cells(const stp_grid* grid, __m256i x, __m256i y, __m256i z)
{
    assert(grid->mask >= 63 && (grid->mask & (grid->mask + 1)) == 0);
    __m256i hash = multiply(_mm256_srli_epi32(x, 2), 0x9E3779B1u);
    hash = _mm256_xor_si256(hash, multiply(_mm256_srli_epi32(y, 2), 0x85EBCA77u));
    hash = _mm256_xor_si256(hash, multiply(_mm256_srli_epi32(z, 2), 0xC2B2AE3Du));
    hash = _mm256_xor_si256(hash, _mm256_srli_epi32(hash, 15));
    hash = multiply(hash, 0x2C1B3C6Du);
    hash = _mm256_xor_si256(hash, _mm256_srli_epi32(hash, 13));
    __m256i within = _mm256_or_si256(within_block(z, 4), within_block(y, 2));
    within = _mm256_or_si256(within, within_block(x, 0));
    hash = _mm256_or_si256(_mm256_slli_epi32(hash, 6), within);
    return _mm256_and_si256(hash, _mm256_set1_epi32((int)grid->mask));
}

static inline __m256 load_apart(const float* p, size_t stride)
{
    return _mm256_setr_ps(p[0], p[stride], p[2 * stride], p[3 * stride], p[4 * stride],
                          p[5 * stride], p[6 * stride], p[7 * stride]);
}

static void find_buckets(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                         size_t end, uint32_t* buckets)
{
    assert(begin <= end && points->stride > 0);
    bool triples = points->stride == 3 && points->y == points->x + 1 && points->z == points->x + 2;
    size_t i = begin;
    for (; end - i >= LANES; i += LANES) {
        size_t at = i * points->stride;
        __m256 x, y, z;
        if (triples) {
            stp_load_triples(points->x + at, &x, &y, &z);
        } else {
            x = load_apart(points->x + at, points->stride);
            y = load_apart(points->y + at, points->stride);
            z = load_apart(points->z + at, points->stride);
        }
        __m256i bucket =
            hash_cells(grid, find_cells(grid, x), find_cells(grid, y), find_cells(grid, z));
        _mm256_storeu_si256((__m256i*)(buckets + i), bucket);
    }
    assert(end - i < LANES && "fewer points than lanes are left");
    stp_grid_kernels_portable.find_buckets(grid, points, i, end, buckets);
}

const stp_grid_kernels stp_grid_kernels_avx2 = {find_buckets};

#endif
