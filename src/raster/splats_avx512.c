// SPDX-License-Identifier: MIT
// Splats with 512-bit vectors: sixteen pixels of a small disk at a time.
#include "raster/splats_kernel.h"

#include <assert.h>
#include <immintrin.h>

/// 48 grid coordinates, deinterleaved.
static inline void load_positions(const uint16_t* positions, splat_batch* batch)
{
    static const uint16_t order[48] = {0, 3, 6, 9,  12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45,
                                       1, 4, 7, 10, 13, 16, 19, 22, 25, 28, 31, 34, 37, 40, 43, 46,
                                       2, 5, 8, 11, 14, 17, 20, 23, 26, 29, 32, 35, 38, 41, 44, 47};
    __m512i low = _mm512_loadu_si512(positions);
    __m512i high = _mm512_castsi256_si512(_mm256_loadu_si256((const __m256i_u*)(positions + 32)));
    float* out[3] = {batch->px, batch->py, batch->pz};
    for (int k = 0; k < 3; ++k) {
        __m512i index =
            _mm512_castsi256_si512(_mm256_loadu_si256((const __m256i_u*)(order + 16 * k)));
        __m256i words = _mm512_castsi512_si256(_mm512_permutex2var_epi16(low, index, high));
        _mm512_storeu_ps(out[k], _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(words)));
    }
}

/// 16 pairs of bytes.
static inline void load_normals(const int8_t* normals, splat_batch* batch)
{
    __m512i pairs = _mm512_cvtepi16_epi32(_mm256_loadu_si256((const __m256i_u*)normals));
    __m512i u = _mm512_srai_epi32(_mm512_slli_epi32(pairs, 24), 24);
    __m512i v = _mm512_srai_epi32(pairs, 8);
    _mm512_storeu_ps(batch->nu, _mm512_cvtepi32_ps(u));
    _mm512_storeu_ps(batch->nv, _mm512_cvtepi32_ps(v));
}

static inline uint32_t lanes_of(const splat_batch* batch, splat_kind kind)
{
    return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(batch->kind), _mm512_set1_epi32((int)kind));
}

/// splat_has_fragment for sixteen fragments.
static inline __mmask16 hash_fragments(uint32_t coverage, uint32_t index, __m512i dx, __m512i dy)
{
    __m512i h = _mm512_set1_epi32((int)(index * 0x9E3779B1u + 0x7F4A7C15u));
    h = _mm512_xor_si512(
        h, _mm512_add_epi32(_mm512_mullo_epi32(dx, _mm512_set1_epi32((int)0x85EBCA6Bu)),
                            _mm512_mullo_epi32(dy, _mm512_set1_epi32((int)0xC2B2AE35u))));
    h = _mm512_xor_si512(h, _mm512_srli_epi32(h, 15));
    h = _mm512_mullo_epi32(h, _mm512_set1_epi32(0x2C1B3C6D));
    h = _mm512_xor_si512(h, _mm512_srli_epi32(h, 13));
    h = _mm512_mullo_epi32(h, _mm512_set1_epi32(0x297A2D39));
    __m512i maximum = _mm512_set1_epi32((int)(coverage + (coverage >> 7)));
    return _mm512_cmplt_epu32_mask(_mm512_srli_epi32(h, 24), maximum);
}

/// Evaluates disk `i` at sixteen pixels (u, v). Returns the mask of those inside, and their depth
/// bits.
static inline __mmask16 evaluate(const stp_splat_frame* f, const splat_batch* t, int i, __m512 u,
                                 __m512 v, __m512i* bits)
{
    __m512 a = _mm512_set1_ps(t->a[i]), b = _mm512_set1_ps(t->b[i]), c = _mm512_set1_ps(t->c[i]);
    __m512 p = _mm512_set1_ps(t->p[i]), q = _mm512_set1_ps(t->q[i]);
    __m512 across = _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(a, u), _mm512_mul_ps(b, v)), p);
    __m512 down = _mm512_add_ps(_mm512_mul_ps(c, v), q);
    __m512 value = _mm512_add_ps(_mm512_mul_ps(u, across), _mm512_mul_ps(v, down));
    __m512 maximum = _mm512_set1_ps(t->g_limit[i]);
    __m512 change = _mm512_add_ps(_mm512_mul_ps(_mm512_set1_ps(t->gx[i]), u),
                                  _mm512_mul_ps(_mm512_set1_ps(t->gy[i]), v));
    __m512 minimum = _mm512_sub_ps(_mm512_setzero_ps(), maximum);
    change = _mm512_mask_mov_ps(change, _mm512_cmp_ps_mask(change, maximum, _CMP_GT_OQ), maximum);
    change = _mm512_mask_mov_ps(change, _mm512_cmp_ps_mask(change, minimum, _CMP_LT_OQ), minimum);
    __m512 limit = _mm512_set1_ps(t->limit[i]);
    __m512 rim = _mm512_mul_ps(_mm512_min_ps(value, limit), _mm512_set1_ps(t->rim[i]));
    __m512 at = _mm512_sub_ps(_mm512_add_ps(_mm512_set1_ps(t->nearness[i]), change), rim);
    at = _mm512_max_ps(at, _mm512_set1_ps(SPLAT_MIN_NEARNESS));
    at = _mm512_min_ps(at, _mm512_set1_ps(f->nearness_limit));
    *bits = _mm512_xor_si512(_mm512_castps_si512(at), _mm512_set1_epi32(-1));
    return _mm512_cmp_ps_mask(value, limit, _CMP_LE_OQ);
}

/// Clips the fragments in a mask to the drawn part of disk `i`.
static inline uint32_t keep_clipped(const splat_batch* t, int i, __m512 u, __m512 v, uint32_t mask)
{
    __m512 at = _mm512_add_ps(_mm512_mul_ps(_mm512_set1_ps(t->ex[i]), u),
                              _mm512_mul_ps(_mm512_set1_ps(t->ey[i]), v));
    return mask & _mm512_cmp_ps_mask(at, _mm512_set1_ps(t->low[i]), _CMP_GE_OQ) &
           _mm512_cmp_ps_mask(at, _mm512_set1_ps(t->high[i]), _CMP_LE_OQ);
}

/// Draws a disk within 4 x 4 pixels, all of them in the target.
static inline uint64_t draw_small(const stp_splat_frame* f, const splat_batch* t, int i,
                                  uint32_t index)
{
    assert(is_block_inside(f, t, i));
    const __m512 columns = _mm512_setr_ps(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
    const __m512 rows = _mm512_setr_ps(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    __m512 u = _mm512_add_ps(_mm512_set1_ps(t->u0[i]), columns);
    __m512 v = _mm512_add_ps(_mm512_set1_ps(t->v0[i]), rows);
    __m512i bits;
    uint32_t mask = evaluate(f, t, i, u, v, &bits);
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    if ((t->clips >> i & 1u) != 0) {
        mask = keep_clipped(t, i, u, v, mask);
    }
    if (coverage < 255) {
        __m512i dx =
            _mm512_add_epi32(_mm512_cvttps_epi32(columns), _mm512_set1_epi32(t->x0[i] - t->cx[i]));
        __m512i dy =
            _mm512_add_epi32(_mm512_cvttps_epi32(rows), _mm512_set1_epi32(t->y0[i] - t->cy[i]));
        mask &= hash_fragments(coverage, f->seed + index, dx, dy);
    }
    const __m512i pair_low =
        _mm512_setr_epi32(16, 0, 17, 1, 18, 2, 19, 3, 20, 4, 21, 5, 22, 6, 23, 7);
    const __m512i pair_high =
        _mm512_setr_epi32(16, 8, 17, 9, 18, 10, 19, 11, 20, 12, 21, 13, 22, 14, 23, 15);
    __m512i id = _mm512_set1_epi32((int)(f->first_id + index));
    __m512i low = _mm512_permutex2var_epi32(bits, pair_low, id);
    __m512i high = _mm512_permutex2var_epi32(bits, pair_high, id);
    const __m512i empty = _mm512_set1_epi64(-1);
    low = _mm512_mask_mov_epi64(empty, (__mmask8)mask, low);
    high = _mm512_mask_mov_epi64(empty, (__mmask8)(mask >> 8), high);
    uint64_t* pixel = f->target->pixels + (size_t)t->y0[i] * f->target->stride + (size_t)t->x0[i];
    __m256i row[4] = {_mm512_castsi512_si256(low), _mm512_extracti64x4_epi64(low, 1),
                      _mm512_castsi512_si256(high), _mm512_extracti64x4_epi64(high, 1)};
    for (int k = 0; k < 4; ++k, pixel += f->target->stride) {
        __m256i old = _mm256_loadu_si256((const __m256i_u*)pixel);
        _mm256_storeu_si256((__m256i_u*)pixel, _mm256_min_epu64(old, row[k]));
    }
    return (uint64_t)__builtin_popcount(mask);
}

/// Stores eight pixels of a row.
static inline void store_eight(uint64_t* pixel, __mmask8 mask, __m256i bits, __m512i id)
{
    __m512i value = _mm512_or_si512(_mm512_slli_epi64(_mm512_cvtepu32_epi64(bits), 32), id);
    __m512i old = _mm512_maskz_loadu_epi64(mask, pixel);
    _mm512_mask_storeu_epi64(pixel, mask, _mm512_min_epu64(old, value));
}

/// Draws a disk at most eight pixels wide, two rows at a time.
static inline uint64_t draw_eight(const stp_splat_frame* f, const splat_batch* t, int i,
                                  uint32_t index, splat_box box)
{
    const __m512i steps = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
    const __m512i rows = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    assert(box.x0 <= box.x1 && box.x1 - box.x0 <= 8);
    uint32_t columns = (1u << (box.x1 - box.x0)) - 1u;
    bool is_clipped = (t->clips >> i & 1u) != 0;
    __m512i id = _mm512_set1_epi64((long long)(f->first_id + index));
    __m512i column = _mm512_add_epi32(_mm512_set1_epi32(box.x0 - t->x0[i]), steps);
    __m512 u = _mm512_add_ps(_mm512_set1_ps(t->u0[i]), _mm512_cvtepi32_ps(column));
    uint64_t* pixel = f->target->pixels + (size_t)box.y0 * f->target->stride + (size_t)box.x0;
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; y += 2) {
        __m512i row = _mm512_add_epi32(_mm512_set1_epi32(y - t->y0[i]), rows);
        __m512 v = _mm512_add_ps(_mm512_set1_ps(t->v0[i]), _mm512_cvtepi32_ps(row));
        __m512i bits;
        uint32_t mask = evaluate(f, t, i, u, v, &bits);
        mask &= y + 1 < box.y1 ? columns | columns << 8 : columns;
        if (is_clipped) {
            mask = keep_clipped(t, i, u, v, mask);
        }
        if (coverage < 255) {
            __m512i dx = _mm512_add_epi32(_mm512_set1_epi32(box.x0 - t->cx[i]), steps);
            __m512i dy = _mm512_add_epi32(_mm512_set1_epi32(y - t->cy[i]), rows);
            mask &= hash_fragments(coverage, f->seed + index, dx, dy);
        }
        fragments += (uint64_t)__builtin_popcount(mask);
        // unconditional: the branch would be unpredictable
        store_eight(pixel, (__mmask8)mask, _mm512_castsi512_si256(bits), id);
        store_eight(pixel + (y + 1 < box.y1 ? f->target->stride : 0), (__mmask8)(mask >> 8),
                    _mm512_extracti64x4_epi64(bits, 1), id);
        pixel += 2 * f->target->stride;
    }
    return fragments;
}

/// Draws a disk with any box, sixteen columns at a time.
static uint64_t draw_wide(const stp_splat_frame* f, const splat_batch* t, int i, uint32_t index)
{
    const __m512i steps = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    splat_box box = clip_box(f, t, i);
    if (box.x1 - box.x0 <= 8) {
        return draw_eight(f, t, i, index, box);
    }
    bool is_clipped = (t->clips >> i & 1u) != 0;
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    __m512i id = _mm512_set1_epi64((long long)(f->first_id + index));
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        uint64_t* row = f->target->pixels + (size_t)y * f->target->stride;
        __m512 v = _mm512_set1_ps(t->v0[i] + (float)(y - t->y0[i]));
        for (int32_t x = box.x0; x < box.x1; x += 16) {
            __m512i column = _mm512_add_epi32(_mm512_set1_epi32(x - t->x0[i]), steps);
            __m512 u = _mm512_add_ps(_mm512_set1_ps(t->u0[i]), _mm512_cvtepi32_ps(column));
            __m512i bits;
            uint32_t mask = evaluate(f, t, i, u, v, &bits);
            mask &= box.x1 - x < 16 ? (1u << (box.x1 - x)) - 1u : 0xFFFFu;
            if (is_clipped) {
                mask = keep_clipped(t, i, u, v, mask);
            }
            if (coverage < 255) {
                __m512i dx = _mm512_add_epi32(_mm512_set1_epi32(x - t->cx[i]), steps);
                mask &=
                    hash_fragments(coverage, f->seed + index, dx, _mm512_set1_epi32(y - t->cy[i]));
            }
            fragments += (uint64_t)__builtin_popcount(mask);
            for (int half = 0; half < 2 && mask >> (8 * half) != 0; ++half) {
                __mmask8 eight = (__mmask8)(mask >> (8 * half));
                __m256i part =
                    half == 0 ? _mm512_castsi512_si256(bits) : _mm512_extracti64x4_epi64(bits, 1);
                store_eight(row + x + 8 * half, eight, part, id);
            }
        }
    }
    return fragments;
}

#include "raster/splats_batches.h"

uint64_t stp_splats_draw_wide(const stp_splat_frame* frame)
{
    return draw_all(frame);
}

bool stp_splats_test_wide(const stp_splat_frame* frame, uint16_t* bits)
{
    return test_all(frame, bits);
}
