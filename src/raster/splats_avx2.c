// SPDX-License-Identifier: MIT
// Splats with 256-bit vectors: two rows of four pixels of a small disk at a time.
#include "raster/splats_kernel.h"

#include <assert.h>

#if defined(__AVX2__)

#include <immintrin.h>

/// 24 grid coordinates, deinterleaved into eight of each.
static inline void load_eight_positions(const uint16_t* positions, float* x, float* y, float* z)
{
    enum { Z = -1 };
    const __m128i* at = (const __m128i*)(const void*)positions;
    __m128i a = _mm_loadu_si128(at), b = _mm_loadu_si128(at + 1), c = _mm_loadu_si128(at + 2);
    // a: x0 y0 z0 x1 y1 z1 x2 y2   b: z2 x3 y3 z3 x4 y4 z4 x5   c: y5 z5 x6 y6 z6 x7 y7 z7
    __m128i xs = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(0, 1, 6, 7, 12, 13, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, 2, 3, 8, 9, 14, 15, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 4, 5, 10, 11)));
    __m128i ys = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(2, 3, 8, 9, 14, 15, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, 4, 5, 10, 11, Z, Z, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 0, 1, 6, 7, 12, 13)));
    __m128i zs = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(4, 5, 10, 11, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, 0, 1, 6, 7, 12, 13, Z, Z, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 2, 3, 8, 9, 14, 15)));
    _mm256_storeu_ps(x, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(xs)));
    _mm256_storeu_ps(y, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(ys)));
    _mm256_storeu_ps(z, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(zs)));
}

/// Eight pairs of bytes.
static inline void load_eight_normals(const int8_t* normals, float* nu, float* nv)
{
    __m256i pairs = _mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i*)(const void*)normals));
    __m256i u = _mm256_srai_epi32(_mm256_slli_epi32(pairs, 24), 24);
    __m256i v = _mm256_srai_epi32(pairs, 8);
    _mm256_storeu_ps(nu, _mm256_cvtepi32_ps(u));
    _mm256_storeu_ps(nv, _mm256_cvtepi32_ps(v));
}

static inline uint32_t lanes_of(const splat_batch* batch, splat_kind kind)
{
    __m256i wanted = _mm256_set1_epi32((int)kind);
    __m256i low = _mm256_loadu_si256((const __m256i_u*)batch->kind);
    __m256i high = _mm256_loadu_si256((const __m256i_u*)(batch->kind + 8));
    int a = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(low, wanted)));
    int b = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(high, wanted)));
    return (uint32_t)a | (uint32_t)b << 8;
}

/// splat_has_fragment for eight fragments: all bits set for those kept.
static inline __m256i hash_fragments(uint32_t coverage, uint32_t index, __m256i dx, __m256i dy)
{
    __m256i h = _mm256_set1_epi32((int)(index * 0x9E3779B1u + 0x7F4A7C15u));
    h = _mm256_xor_si256(
        h, _mm256_add_epi32(_mm256_mullo_epi32(dx, _mm256_set1_epi32((int)0x85EBCA6Bu)),
                            _mm256_mullo_epi32(dy, _mm256_set1_epi32((int)0xC2B2AE35u))));
    h = _mm256_xor_si256(h, _mm256_srli_epi32(h, 15));
    h = _mm256_mullo_epi32(h, _mm256_set1_epi32(0x2C1B3C6D));
    h = _mm256_xor_si256(h, _mm256_srli_epi32(h, 13));
    h = _mm256_mullo_epi32(h, _mm256_set1_epi32(0x297A2D39));
    __m256i maximum = _mm256_set1_epi32((int)(coverage + (coverage >> 7)));
    return _mm256_cmpgt_epi32(maximum, _mm256_srli_epi32(h, 24));
}

/// The value of disk `i`'s conic at eight pixels (u, v): inside up to its limit.
static inline __m256 conic_at(const splat_batch* t, int i, __m256 u, __m256 v)
{
    __m256 a = _mm256_set1_ps(t->a[i]), b = _mm256_set1_ps(t->b[i]), c = _mm256_set1_ps(t->c[i]);
    __m256 p = _mm256_set1_ps(t->p[i]), q = _mm256_set1_ps(t->q[i]);
    __m256 across = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a, u), _mm256_mul_ps(b, v)), p);
    __m256 down = _mm256_add_ps(_mm256_mul_ps(c, v), q);
    return _mm256_add_ps(_mm256_mul_ps(u, across), _mm256_mul_ps(v, down));
}

/// All bits set for the values inside disk `i`.
static inline __m256i is_inside(const splat_batch* t, int i, __m256 value)
{
    return _mm256_castps_si256(_mm256_cmp_ps(value, _mm256_set1_ps(t->limit[i]), _CMP_LE_OQ));
}

/// Depth bits of disk `i` at eight pixels (u, v), where its conic has this value.
static inline __m256i depth_at(const stp_splat_frame* f, const splat_batch* t, int i, __m256 u,
                               __m256 v, __m256 value)
{
    __m256 maximum = _mm256_set1_ps(t->g_limit[i]);
    __m256 change = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(t->gx[i]), u),
                                  _mm256_mul_ps(_mm256_set1_ps(t->gy[i]), v));
    __m256 minimum = _mm256_sub_ps(_mm256_setzero_ps(), maximum);
    change = _mm256_blendv_ps(change, maximum, _mm256_cmp_ps(change, maximum, _CMP_GT_OQ));
    change = _mm256_blendv_ps(change, minimum, _mm256_cmp_ps(change, minimum, _CMP_LT_OQ));
    __m256 limit = _mm256_set1_ps(t->limit[i]);
    __m256 rim = _mm256_mul_ps(_mm256_min_ps(value, limit), _mm256_set1_ps(t->rim[i]));
    __m256 at = _mm256_sub_ps(_mm256_add_ps(_mm256_set1_ps(t->nearness[i]), change), rim);
    at = _mm256_max_ps(at, _mm256_set1_ps(SPLAT_MIN_NEARNESS));
    at = _mm256_min_ps(at, _mm256_set1_ps(f->nearness_limit));
    return _mm256_xor_si256(_mm256_castps_si256(at), _mm256_set1_epi32(-1));
}

/// Clips the fragments inside disk `i` to its drawn part.
static inline __m256i keep_clipped(const splat_batch* t, int i, __m256 u, __m256 v, __m256i inside)
{
    __m256 at = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(t->ex[i]), u),
                              _mm256_mul_ps(_mm256_set1_ps(t->ey[i]), v));
    __m256 kept = _mm256_and_ps(_mm256_cmp_ps(at, _mm256_set1_ps(t->low[i]), _CMP_GE_OQ),
                                _mm256_cmp_ps(at, _mm256_set1_ps(t->high[i]), _CMP_LE_OQ));
    return _mm256_and_si256(inside, _mm256_castps_si256(kept));
}

/// Stores four pixels where `inside` (32-bit masks) is set. Depth bits always begin with a set bit,
/// so the signed comparison orders pixels like an unsigned one, including empty ones.
static inline void store_four(uint64_t* pixel, __m128i bits, __m128i inside, __m256i id)
{
    __m256i value = _mm256_or_si256(_mm256_slli_epi64(_mm256_cvtepu32_epi64(bits), 32), id);
    __m256i old = _mm256_loadu_si256((const __m256i_u*)pixel);
    __m256i nearer =
        _mm256_and_si256(_mm256_cmpgt_epi64(old, value), _mm256_cvtepi32_epi64(inside));
    _mm256_storeu_si256((__m256i_u*)pixel, _mm256_blendv_epi8(old, value, nearer));
}

/// Draws a disk within 4 x 4 pixels, all of them in the target.
static inline uint64_t draw_small(const stp_splat_frame* f, const splat_batch* t, int i,
                                  uint32_t index)
{
    assert(is_block_inside(f, t, i));
    const __m256 columns = _mm256_setr_ps(0, 1, 2, 3, 0, 1, 2, 3);
    __m256 u = _mm256_add_ps(_mm256_set1_ps(t->u0[i]), columns);
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    __m256i id = _mm256_set1_epi64x((long long)(f->first_id + index));
    uint64_t* pixel = f->target->pixels + (size_t)t->y0[i] * f->target->stride + (size_t)t->x0[i];
    uint64_t fragments = 0;
    for (int half = 0; half < 2; ++half) {
        float row = 2.0f * (float)half;
        __m256 rows = _mm256_setr_ps(row, row, row, row, row + 1, row + 1, row + 1, row + 1);
        __m256 v = _mm256_add_ps(_mm256_set1_ps(t->v0[i]), rows);
        __m256 value = conic_at(t, i, u, v);
        __m256i inside = is_inside(t, i, value), bits = depth_at(f, t, i, u, v, value);
        if ((t->clips >> i & 1u) != 0) {
            inside = keep_clipped(t, i, u, v, inside);
        }
        if (coverage < 255) {
            __m256i dx = _mm256_add_epi32(_mm256_cvttps_epi32(columns),
                                          _mm256_set1_epi32(t->x0[i] - t->cx[i]));
            __m256i dy =
                _mm256_add_epi32(_mm256_cvttps_epi32(rows), _mm256_set1_epi32(t->y0[i] - t->cy[i]));
            inside = _mm256_and_si256(inside, hash_fragments(coverage, f->seed + index, dx, dy));
        }
        fragments +=
            (uint64_t)__builtin_popcount((unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(inside)));
        store_four(pixel, _mm256_castsi256_si128(bits), _mm256_castsi256_si128(inside), id);
        pixel += f->target->stride;
        store_four(pixel, _mm256_extracti128_si256(bits, 1), _mm256_extracti128_si256(inside, 1),
                   id);
        pixel += f->target->stride;
    }
    return fragments;
}

/// Draws a disk with any box, eight columns at a time; columns outside of it are masked.
static uint64_t draw_wide(const stp_splat_frame* f, const splat_batch* t, int i, uint32_t index)
{
    const __m256i steps = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    splat_box box = clip_box(f, t, i);
    int32_t width = (int32_t)f->target->width;
    if (width < 8) {
        return draw_disk_scalar(f, t, i, index, box);
    }
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    bool is_clipped = (t->clips >> i & 1u) != 0;
    __m256i id = _mm256_set1_epi64x((long long)(f->first_id + index));
    uint64_t fragments = 0;
    for (int32_t left = box.x0; left < box.x1; left += 8) {
        int32_t x = left + 8 <= width ? left : width - 8; // the vector stays in the row
        __m256i at = _mm256_add_epi32(_mm256_set1_epi32(x), steps);
        __m256i there = _mm256_and_si256(_mm256_cmpgt_epi32(at, _mm256_set1_epi32(left - 1)),
                                         _mm256_cmpgt_epi32(_mm256_set1_epi32(box.x1), at));
        __m256i column = _mm256_sub_epi32(at, _mm256_set1_epi32(t->x0[i]));
        __m256 u = _mm256_add_ps(_mm256_set1_ps(t->u0[i]), _mm256_cvtepi32_ps(column));
        for (int32_t y = box.y0; y < box.y1; ++y) {
            uint64_t* row = f->target->pixels + (size_t)y * f->target->stride + (size_t)x;
            __m256 v = _mm256_set1_ps(t->v0[i] + (float)(y - t->y0[i]));
            __m256 value = conic_at(t, i, u, v);
            __m256i inside = _mm256_and_si256(is_inside(t, i, value), there);
            if (_mm256_testz_si256(inside, inside) != 0) {
                continue;
            }
            if (is_clipped) {
                inside = keep_clipped(t, i, u, v, inside);
            }
            if (coverage < 255) {
                __m256i dx = _mm256_sub_epi32(at, _mm256_set1_epi32(t->cx[i]));
                __m256i dy = _mm256_set1_epi32(y - t->cy[i]);
                inside =
                    _mm256_and_si256(inside, hash_fragments(coverage, f->seed + index, dx, dy));
            }
            unsigned mask = (unsigned)_mm256_movemask_ps(_mm256_castsi256_ps(inside));
            __m256i bits = depth_at(f, t, i, u, v, value);
            fragments += (uint64_t)__builtin_popcount(mask);
            if ((mask & 15) != 0) {
                store_four(row, _mm256_castsi256_si128(bits), _mm256_castsi256_si128(inside), id);
            }
            if (mask >> 4 != 0) {
                store_four(row + 4, _mm256_extracti128_si256(bits, 1),
                           _mm256_extracti128_si256(inside, 1), id);
            }
        }
    }
    return fragments;
}

static inline void load_positions(const uint16_t* positions, splat_batch* t)
{
    load_eight_positions(positions, t->px, t->py, t->pz);
    load_eight_positions(positions + 24, t->px + 8, t->py + 8, t->pz + 8);
}

static inline void load_normals(const int8_t* normals, splat_batch* t)
{
    load_eight_normals(normals, t->nu, t->nv);
    load_eight_normals(normals + 16, t->nu + 8, t->nv + 8);
}

#include "raster/splats_batches.h"

uint64_t stp_splats_draw_avx2(const stp_splat_frame* frame)
{
    return draw_all(frame);
}

bool stp_splats_test_avx2(const stp_splat_frame* frame, uint16_t* bits)
{
    return test_all(frame, bits);
}

#else

uint64_t stp_splats_draw_avx2(const stp_splat_frame* frame)
{
    return stp_splats_draw_portable(frame);
}

bool stp_splats_test_avx2(const stp_splat_frame* frame, uint16_t* bits)
{
    return stp_splats_test_portable(frame, bits);
}

#endif
