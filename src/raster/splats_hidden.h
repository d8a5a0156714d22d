// SPDX-License-Identifier: MIT
//
// Occlusion test of splats, sixteen at a time: branch-free loops, which compilers vectorise.
#pragma once

#include "raster/splats_kernel.h"

#include <assert.h>

/// For each splat of a batch: the blocks of the occluder it may touch, and the nearness at which
/// they hide it.
typedef struct splat_blocks {
    float left[SPLAT_BATCH], top[SPLAT_BATCH], right[SPLAT_BATCH], bottom[SPLAT_BATCH];
    float nearest[SPLAT_BATCH];
    float minimum[SPLAT_BATCH]; ///< over the windows that it touches
    int32_t asked[SPLAT_BATCH];
    int32_t first[SPLAT_BATCH], across[SPLAT_BATCH],
        down[SPLAT_BATCH]; ///< index of a window, and steps to the last ones
} splat_blocks;

static inline void find_extents(const stp_splat_frame* restrict f, const splat_batch* restrict t,
                                splat_blocks* restrict k)
{
    const stp_raster_occluder* o = f->splats->occluder;
    float right = o->width - 1.0f, bottom = o->height - 1.0f, inverse_scale = 1.0f / o->pixel_scale;
    float apart = o->apart, half = 0.5f * inverse_scale; // splats count as at least half a pixel
    float wider = 1.1f * o->corner, near = o->near_distance, minimum = near * o->behind;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float x = t->px[i], y = t->py[i], z = t->pz[i];
        float X = ((f->occluder[0][0] * x + f->occluder[0][1] * y) + f->occluder[0][2] * z) +
                  f->occluder[0][3];
        float Y = ((f->occluder[1][0] * x + f->occluder[1][1] * y) + f->occluder[1][2] * z) +
                  f->occluder[1][3];
        float W = ((f->occluder[2][0] * x + f->occluder[2][1] * y) + f->occluder[2][2] * z) +
                  f->occluder[2][3];
        float inverse = 1.0f / W;
        float sx = X * inverse, sy = Y * inverse;
        float radius = f->occluder_radius * inverse * t->own[i];
        float ratio = radius * inverse_scale; // radius over depth
        float extent = radius * wider + 0.51f;
        // for a ratio up to a twelfth, 1 / (1 - ratio) is below 1 + 1.1 ratio and below 1.1
        k->nearest[i] = minimum * inverse * (1.0f + 1.1f * ratio) * (1.0f + apart * (ratio + half));
        float x0 = sx - extent, y0 = sy - extent, x1 = sx + extent, y1 = sy + extent;
        int32_t asked = (int32_t)(W > near) & (int32_t)(ratio < 0.08f) & (int32_t)(x1 >= 0.0f) &
                        (int32_t)(y1 >= 0.0f) & (int32_t)(x0 <= right) & (int32_t)(y0 <= bottom);
        x0 = x0 > 0.0f ? x0 : 0.0f;
        y0 = y0 > 0.0f ? y0 : 0.0f;
        x1 = x1 < right ? x1 : right;
        y1 = y1 < bottom ? y1 : bottom;
        k->left[i] = asked != 0 ? x0 : 0.0f;
        k->top[i] = asked != 0 ? y0 : 0.0f;
        k->right[i] = asked != 0 ? x1 : 0.0f;
        k->bottom[i] = asked != 0 ? y1 : 0.0f;
        k->asked[i] = asked;
    }
}

/// Windows are two blocks wide and high: those at the corners cover up to four blocks per side.
static inline void find_windows(const stp_raster_occluder* o, splat_blocks* restrict k)
{
    int32_t columns = (int32_t)o->columns;
    float per_pixel = 1.0f / (float)(1u << o->shift);
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        int32_t x0 = (int32_t)(k->left[i] * per_pixel), x1 = (int32_t)(k->right[i] * per_pixel);
        int32_t y0 = (int32_t)(k->top[i] * per_pixel), y1 = (int32_t)(k->bottom[i] * per_pixel);
        int32_t across = x1 - x0, down = y1 - y0;
        k->asked[i] &= (int32_t)(across < STP_RASTER_OCCLUDER_BLOCKS) &
                       (int32_t)(down < STP_RASTER_OCCLUDER_BLOCKS);
        k->first[i] = y0 * columns + x0;
        k->across[i] = across > 1 ? across - 1 : 0;
        k->down[i] = down > 1 ? (down - 1) * columns : 0;
    }
}

static inline void find_in_windows(const stp_raster_occluder* o, splat_blocks* restrict k)
{
    const float* windows = o->windows;
    assert(o->columns > 0 && (float)(o->columns << o->shift) >= o->width &&
           "blocks cover the picture");
    int32_t wide = 0;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        wide |= (k->across[i] | k->down[i]) & -k->asked[i];
    }
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        k->minimum[i] = windows[k->first[i]];
    }
    if (wide == 0) {
        return;
    }
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        if (k->asked[i] == 0) {
            continue; // may extend beyond the last row
        }
        const float* at = windows + k->first[i];
        float a = at[k->across[i]], b = at[k->down[i]], c = at[k->down[i] + k->across[i]];
        a = a < b ? a : b;
        a = a < c ? a : c;
        k->minimum[i] = a < k->minimum[i] ? a : k->minimum[i];
    }
}

/// Finds which splats of a batch the occluder hides, from their positions: 1 or 0 in `asked`.
static inline void find_hidden(const stp_splat_frame* restrict f, const splat_batch* restrict t,
                               splat_blocks* restrict k)
{
    find_extents(f, t, k);
    find_windows(f->splats->occluder, k);
    find_in_windows(f->splats->occluder, k);
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        k->asked[i] &= (int32_t)(k->minimum[i] > k->nearest[i]);
    }
}

/// Marks the splats of a batch that the occluder hides as hidden.
static inline void drop_hidden(const stp_splat_frame* restrict f, splat_batch* restrict t)
{
    splat_blocks k;
    find_hidden(f, t, &k);
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        int32_t kind = t->kind[i];
        int32_t drawn = (int32_t)(kind == SPLAT_PIXEL) | (int32_t)(kind == SPLAT_DISK);
        t->kind[i] = (k.asked[i] & drawn) != 0 ? SPLAT_HIDDEN : kind;
    }
}

/// Removes unwanted and hidden splats from a projected batch. Queued splats are wanted.
static inline void pick_batch(const stp_splat_frame* restrict f, splat_batch* restrict t,
                              splat_lanes lanes)
{
    const stp_raster_splats* splats = f->splats;
    bool asks = splats->wanted != NULL && lanes.queued == NULL;
    uint32_t wanted = asks ? splats->wanted[lanes.first / SPLAT_BATCH] : 0xFFFFu;
    wanted &= lanes.count < SPLAT_BATCH ? (1u << lanes.count) - 1u : 0xFFFFu;
    int32_t large = 0;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        int32_t there = -(int32_t)(wanted >> i & 1u);
        t->kind[i] &= there;
        large |= (int32_t)(t->kind[i] == SPLAT_LARGE);
    }
    if (large != 0) {
        drop_beside(f, t);
    }
    if (splats->occluder != NULL) {
        drop_hidden(f, t);
    }
}

/// Splats queued until there are sixteen.
typedef struct waiting_splats {
    uint32_t index[SPLAT_BATCH];
    uint32_t count;
} waiting_splats;

/// Clears the bits of queued splats that the occluder hides.
static inline void test_queued(const stp_splat_frame* f, waiting_splats* w, uint16_t* bits)
{
    const uint16_t* positions = f->splats->positions;
    const uint32_t* shapes = f->splats->shapes;
    assert(w->count > 0 && w->count <= SPLAT_BATCH);
    splat_batch t;
    splat_blocks k;
    for (uint32_t i = 0; i < SPLAT_BATCH; ++i) {
        size_t at = 3 * (size_t)w->index[i < w->count ? i : 0];
        t.px[i] = (float)positions[at];
        t.py[i] = (float)positions[at + 1];
        t.pz[i] = (float)positions[at + 2];
        t.own[i] = shapes != NULL ? stp_shape_radius(shapes[at / 3] & 0xFFFu)
                                  : splat_growth(f->splats, (uint32_t)(at / 3));
    }
    find_hidden(f, &t, &k);
    for (uint32_t i = 0; i < w->count; ++i) {
        uint32_t index = w->index[i];
        uint32_t bit = (uint32_t)k.asked[i] << index % SPLAT_BATCH;
        bits[index / SPLAT_BATCH] = (uint16_t)(bits[index / SPLAT_BATCH] & ~bit);
    }
    w->count = 0;
}

/// The bits of a word that belong to splats before `end`.
static inline uint32_t bits_before(uint32_t end, uint32_t word)
{
    uint32_t left = end - word * SPLAT_BATCH;
    return left < SPLAT_BATCH ? (1u << left) - 1u : 0xFFFFu;
}

static inline bool test_all(const stp_splat_frame* f, uint16_t* bits)
{
    const stp_raster_splats* splats = f->splats;
    uint32_t first = splats->begin / SPLAT_BATCH;
    uint32_t end = (splats->end + SPLAT_BATCH - 1) / SPLAT_BATCH;
    waiting_splats w = {.count = 0};
    for (uint32_t word = first; word < end; ++word) {
        uint32_t left = bits[word] & bits_before(splats->end, word);
        for (; left != 0; left &= left - 1) {
            w.index[w.count++] = word * SPLAT_BATCH + (uint32_t)__builtin_ctz(left);
            if (w.count == SPLAT_BATCH) {
                test_queued(f, &w, bits);
            }
        }
    }
    if (w.count > 0) {
        test_queued(f, &w, bits);
    }
    uint16_t any = 0;
    for (uint32_t word = first; word < end; ++word) {
        any |= (uint16_t)(bits[word] & bits_before(splats->end, word));
    }
    return any != 0;
}
