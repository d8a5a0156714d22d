// SPDX-License-Identifier: MIT
// Splats with vectors of eight numbers: two rows of four pixels of a small disk at a time.
#include "base/math/f32x8.h"
#include "raster/pixels_write.h"
#include "raster/splats_kernel.h"
#include "raster/splats_load.h"

#include <assert.h>

static inline uint32_t lanes_of(const splat_batch* batch, splat_kind kind)
{
    i32x8 wanted = i32x8_set((int)kind);
    i32x8 low = i32x8_equal(i32x8_load(batch->kind), wanted);
    i32x8 high = i32x8_equal(i32x8_load(batch->kind + 8), wanted);
    return i32x8_signs(low) | i32x8_signs(high) << 8;
}

/// splat_has_fragment for eight fragments: all bits set for those kept.
static inline i32x8 hash_fragments(uint32_t coverage, uint32_t index, i32x8 dx, i32x8 dy)
{
    i32x8 h = i32x8_set((int)(index * 0x9E3779B1u + 0x7F4A7C15u));
    h = i32x8_xor(h, i32x8_add(i32x8_mul(dx, i32x8_set((int)0x85EBCA6Bu)),
                               i32x8_mul(dy, i32x8_set((int)0xC2B2AE35u))));
    h = i32x8_xor(h, i32x8_right(h, 15));
    h = i32x8_mul(h, i32x8_set(0x2C1B3C6D));
    h = i32x8_xor(h, i32x8_right(h, 13));
    h = i32x8_mul(h, i32x8_set(0x297A2D39));
    i32x8 maximum = i32x8_set((int)(coverage + (coverage >> 7)));
    return i32x8_greater(maximum, i32x8_right(h, 24));
}

/// The value of disk `i`'s conic at eight pixels (u, v): inside up to its limit.
static inline f32x8 conic_at(const splat_batch* t, int i, f32x8 u, f32x8 v)
{
    f32x8 a = f32x8_set(t->a[i]), b = f32x8_set(t->b[i]), c = f32x8_set(t->c[i]);
    f32x8 p = f32x8_set(t->p[i]), q = f32x8_set(t->q[i]);
    f32x8 across = f32x8_add(f32x8_add(f32x8_mul(a, u), f32x8_mul(b, v)), p);
    f32x8 down = f32x8_add(f32x8_mul(c, v), q);
    return f32x8_add(f32x8_mul(u, across), f32x8_mul(v, down));
}

/// All bits set for the values inside disk `i`.
static inline i32x8 is_inside(const splat_batch* t, int i, f32x8 value)
{
    return f32x8_less_equal(value, f32x8_set(t->limit[i]));
}

/// Depth bits of disk `i` at eight pixels (u, v), where its conic has this value.
static inline i32x8 depth_at(const stp_splat_frame* f, const splat_batch* t, int i, f32x8 u,
                             f32x8 v, f32x8 value)
{
    f32x8 maximum = f32x8_set(t->g_limit[i]);
    f32x8 change = f32x8_add(f32x8_mul(f32x8_set(t->gx[i]), u), f32x8_mul(f32x8_set(t->gy[i]), v));
    f32x8 minimum = f32x8_sub(f32x8_set(0.0f), maximum);
    change = f32x8_select(f32x8_less(maximum, change), maximum, change);
    change = f32x8_select(f32x8_less(change, minimum), minimum, change);
    f32x8 limit = f32x8_set(t->limit[i]);
    f32x8 rim = f32x8_mul(f32x8_min(value, limit), f32x8_set(t->rim[i]));
    f32x8 at = f32x8_sub(f32x8_add(f32x8_set(t->nearness[i]), change), rim);
    at = f32x8_max(at, f32x8_set(SPLAT_MIN_NEARNESS));
    at = f32x8_min(at, f32x8_set(f->nearness_limit));
    return i32x8_xor(f32x8_as_int(at), i32x8_set(-1));
}

/// Clips the fragments inside disk `i` to its drawn part.
static inline i32x8 keep_clipped(const splat_batch* t, int i, f32x8 u, f32x8 v, i32x8 inside)
{
    f32x8 at = f32x8_add(f32x8_mul(f32x8_set(t->ex[i]), u), f32x8_mul(f32x8_set(t->ey[i]), v));
    i32x8 kept = i32x8_and(f32x8_less_equal(f32x8_set(t->low[i]), at),
                           f32x8_less_equal(at, f32x8_set(t->high[i])));
    return i32x8_and(inside, kept);
}

/// Draws a disk within 4 x 4 pixels, all of them in the target.
static inline uint64_t draw_small(const stp_splat_frame* f, const splat_batch* t, int i,
                                  uint32_t index)
{
    assert(is_block_inside(f, t, i));
    static const float steps[8] = {0.0f, 1.0f, 2.0f, 3.0f, 0.0f, 1.0f, 2.0f, 3.0f};
    static const float lines[2][8] = {{0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f, 1.0f},
                                      {2.0f, 2.0f, 2.0f, 2.0f, 3.0f, 3.0f, 3.0f, 3.0f}};
    const f32x8 columns = f32x8_load(steps);
    f32x8 u = f32x8_add(f32x8_set(t->u0[i]), columns);
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    stp_pixel_ids id = stp_pixel_ids_of(f->first_id + index);
    uint64_t* pixel = f->target->pixels + (size_t)t->y0[i] * f->target->stride + (size_t)t->x0[i];
    uint64_t fragments = 0;
    for (int half = 0; half < 2; ++half) {
        f32x8 rows = f32x8_load(lines[half]);
        f32x8 v = f32x8_add(f32x8_set(t->v0[i]), rows);
        f32x8 value = conic_at(t, i, u, v);
        i32x8 inside = is_inside(t, i, value), bits = depth_at(f, t, i, u, v, value);
        if ((t->clips >> i & 1u) != 0) {
            inside = keep_clipped(t, i, u, v, inside);
        }
        if (coverage < 255) {
            i32x8 dx = i32x8_add(f32x8_truncate(columns), i32x8_set(t->x0[i] - t->cx[i]));
            i32x8 dy = i32x8_add(f32x8_truncate(rows), i32x8_set(t->y0[i] - t->cy[i]));
            inside = i32x8_and(inside, hash_fragments(coverage, f->seed + index, dx, dy));
        }
        fragments += (uint64_t)__builtin_popcount(i32x8_signs(inside));
        stp_pixels_write_some(pixel, i32x8_low(bits), i32x8_low(inside), id);
        pixel += f->target->stride;
        stp_pixels_write_some(pixel, i32x8_high(bits), i32x8_high(inside), id);
        pixel += f->target->stride;
    }
    return fragments;
}

/// Draws a disk with any box, eight columns at a time; columns outside of it are masked.
static uint64_t draw_wide(const stp_splat_frame* f, const splat_batch* t, int i, uint32_t index)
{
    const i32x8 steps = i32x8_index();
    splat_box box = clip_box(f, t, i);
    int32_t width = (int32_t)f->target->width;
    if (width < 8) {
        return draw_disk_scalar(f, t, i, index, box);
    }
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    bool is_clipped = (t->clips >> i & 1u) != 0;
    stp_pixel_ids id = stp_pixel_ids_of(f->first_id + index);
    uint64_t fragments = 0;
    for (int32_t left = box.x0; left < box.x1; left += 8) {
        int32_t x = left + 8 <= width ? left : width - 8; // the vector stays in the row
        i32x8 at = i32x8_add(i32x8_set(x), steps);
        i32x8 there =
            i32x8_and(i32x8_greater(at, i32x8_set(left - 1)), i32x8_greater(i32x8_set(box.x1), at));
        i32x8 column = i32x8_sub(at, i32x8_set(t->x0[i]));
        f32x8 u = f32x8_add(f32x8_set(t->u0[i]), i32x8_to_float(column));
        for (int32_t y = box.y0; y < box.y1; ++y) {
            uint64_t* row = f->target->pixels + (size_t)y * f->target->stride + (size_t)x;
            f32x8 v = f32x8_set(t->v0[i] + (float)(y - t->y0[i]));
            f32x8 value = conic_at(t, i, u, v);
            i32x8 inside = i32x8_and(is_inside(t, i, value), there);
            if (i32x8_signs(inside) == 0) {
                continue;
            }
            if (is_clipped) {
                inside = keep_clipped(t, i, u, v, inside);
            }
            if (coverage < 255) {
                i32x8 dx = i32x8_sub(at, i32x8_set(t->cx[i]));
                i32x8 dy = i32x8_set(y - t->cy[i]);
                inside = i32x8_and(inside, hash_fragments(coverage, f->seed + index, dx, dy));
            }
            unsigned mask = i32x8_signs(inside);
            i32x8 bits = depth_at(f, t, i, u, v, value);
            fragments += (uint64_t)__builtin_popcount(mask);
            if ((mask & 15) != 0) {
                stp_pixels_write_some(row, i32x8_low(bits), i32x8_low(inside), id);
            }
            if (mask >> 4 != 0) {
                stp_pixels_write_some(row + 4, i32x8_high(bits), i32x8_high(inside), id);
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

uint64_t stp_splats_draw_vector(const stp_splat_frame* frame)
{
    return draw_all(frame);
}

bool stp_splats_test_vector(const stp_splat_frame* frame, uint16_t* bits)
{
    return test_all(frame, bits);
}
