// SPDX-License-Identifier: MIT
//
// Squares instead of disks, like hardware points (Dachsbacher et al. 2003, section 4). A square
// covers the pixels whose centres are within the projected radius of the splat's centre,
// horizontally and vertically, all at the centre's nearness. Radii, holes, clipping and the offset
// of back-facing splats are those of disks. Each variant compiles this for its own instruction set.
#pragma once

#include "raster/splats_hidden.h"

#include <assert.h>

/// Draws splats close to the eye like all others: squares need no rays.
static inline void keep_close_squares(const stp_splat_frame* f, splat_batch* t)
{
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        bool seen =
            t->nearness[i] > 0.0f && t->nearness[i] <= f->nearness_limit && t->radius[i] > 0.0f;
        t->kind[i] = t->kind[i] != SPLAT_LARGE ? t->kind[i] : seen ? SPLAT_DISK : SPLAT_NONE;
    }
}

static inline int32_t square_edge(float at)
{
    at = at > -SPLAT_FAR ? at : -SPLAT_FAR;
    return (int32_t)floorf(at < SPLAT_FAR ? at : SPLAT_FAR);
}

/// Computes the boxes of squares. Each includes its centre's pixel, so none is empty.
static inline void box_squares(splat_batch* t)
{
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float sx = t->sx[i], sy = t->sy[i], radius = t->radius[i];
        int32_t cx = square_edge(sx), cy = square_edge(sy);
        int32_t x0 = square_edge((sx - radius) + 0.5f), y0 = square_edge((sy - radius) + 0.5f);
        int32_t x1 = square_edge((sx + radius) - 0.5f), y1 = square_edge((sy + radius) - 0.5f);
        bool disk = t->kind[i] == SPLAT_DISK;
        t->cx[i] = disk ? cx : t->cx[i];
        t->cy[i] = disk ? cy : t->cy[i];
        t->x0[i] = x0 < cx ? x0 : cx;
        t->y0[i] = y0 < cy ? y0 : cy;
        t->x1[i] = x1 > cx ? x1 : cx;
        t->y1[i] = y1 > cy ? y1 : cy;
    }
}

/// Clips squares like disks. A clip by one line has no limit on its other side.
static inline void clip_squares(const stp_splat_frame* f, splat_batch* t)
{
    clip_batch(f, t);
    for (uint32_t clips = t->clips; clips != 0; clips &= clips - 1) {
        int i = __builtin_ctz(clips);
        t->low[i] = t->code[i] < STP_COVERAGE_STRIPS ? -FLT_MAX : t->low[i];
    }
}

/// Final classification of a batch after pick_batch: SPLAT_PIXEL, or SPLAT_WIDE with a box.
static inline void place_squares(const stp_splat_frame* f, splat_batch* t, splat_lanes lanes)
{
    bool squares = false;
    keep_close_squares(f, t);
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        squares = squares || t->kind[i] == SPLAT_DISK;
    }
    if (!squares) {
        return;
    }
    if (f->splats->normals != NULL) {
        load_normals_scalar(f, lanes, t);
    }
    box_squares(t);
    shape_batch(f, t); // for the nearness of back-facing splats
    clip_squares(f, t);
    int32_t width = (int32_t)f->target->width;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float nearness = t->nearness[i] > SPLAT_MIN_NEARNESS ? t->nearness[i] : SPLAT_MIN_NEARNESS;
        bool inside =
            t->x1[i] >= 0 && t->x0[i] < width && t->y1[i] >= f->row_begin && t->y0[i] < f->row_end;
        bool disk = t->kind[i] == SPLAT_DISK;
        t->nearness[i] = disk ? nearness : t->nearness[i];
        t->u0[i] = ((float)t->x0[i] + 0.5f) - t->sx[i];
        t->v0[i] = ((float)t->y0[i] + 0.5f) - t->sy[i];
        t->kind[i] = !disk ? t->kind[i] : inside ? SPLAT_WIDE : SPLAT_NONE;
    }
}

/// Draws a square with holes, or a clipped one.
static inline uint64_t draw_square_parts(const stp_splat_frame* f, const splat_batch* t, int i,
                                         uint32_t index, uint32_t coverage)
{
    splat_box box = clip_box(f, t, i);
    uint64_t fragments = 0, pixel = stp_raster_pixel(t->nearness[i], f->first_id + index);
    for (int32_t y = box.y0; y < box.y1; ++y) {
        uint64_t* row = f->target->pixels + (size_t)y * f->target->stride;
        for (int32_t x = box.x0; x < box.x1; ++x) {
            float u = t->u0[i] + (float)(x - t->x0[i]), v = t->v0[i] + (float)(y - t->y0[i]);
            bool there = !splat_is_clipped(t, i, u, v) &&
                         (coverage >= 255 || splat_has_fragment(coverage, f->seed + index,
                                                                x - t->cx[i], y - t->cy[i]));
            if (there) {
                splat_store(&row[x], pixel);
                fragments += 1;
            }
        }
    }
    return fragments;
}

static inline uint64_t draw_square(const stp_splat_frame* f, const splat_batch* t, int i,
                                   uint32_t index)
{
    uint32_t coverage = splat_coverage(f->splats, (uint32_t)t->part[i], t->halvings[i]);
    if (coverage < 255 || (t->clips >> i & 1u) != 0) {
        return draw_square_parts(f, t, i, index, coverage);
    }
    splat_box box = clip_box(f, t, i);
    assert(box.x0 < box.x1 && box.y0 < box.y1 && "the square meets the target");
    uint64_t pixel = stp_raster_pixel(t->nearness[i], f->first_id + index);
    for (int32_t y = box.y0; y < box.y1; ++y) {
        uint64_t* row = f->target->pixels + (size_t)y * f->target->stride;
        for (int32_t x = box.x0; x < box.x1; ++x) {
            row[x] = pixel < row[x] ? pixel : row[x];
        }
    }
    return (uint64_t)(box.x1 - box.x0) * (uint64_t)(box.y1 - box.y0);
}

/// Draws splats first .. first + 15; only the first `count` exist. Their positions must be loaded.
static inline uint64_t draw_square_batch(const stp_splat_frame* f, splat_batch* t, uint32_t first,
                                         uint32_t count)
{
    uint64_t fragments = 0;
    uint32_t hidden = 0, drawn = 0;
    splat_lanes lanes = {first, count, NULL};
    load_shapes(f, lanes, t);
    load_parts(f, lanes, t);
    project_batch(f, t);
    pick_batch(f, t, lanes);
    place_squares(f, t, lanes);
    for (uint32_t i = 0; i < count; ++i) {
        if (t->kind[i] == SPLAT_PIXEL) {
            fragments += draw_pixel(f, t, (int)i, first + i);
        } else if (t->kind[i] == SPLAT_WIDE) {
            fragments += draw_square(f, t, (int)i, first + i);
        }
        hidden |= (uint32_t)(t->kind[i] == SPLAT_HIDDEN) << i;
        drawn |= (uint32_t)splat_is_drawn(t, i) << i;
    }
    count_drawn(f->splats, drawn);
    if (f->splats->hidden != NULL) {
        f->splats->hidden[first / SPLAT_BATCH] = (uint16_t)hidden;
    }
    return fragments;
}

static inline uint64_t draw_all_squares(const stp_splat_frame* f)
{
    const stp_raster_splats* splats = f->splats;
    uint64_t fragments = 0;
    splat_batch batch = empty_batch();
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        uint32_t count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        if (splats->wanted == NULL || splats->wanted[first / SPLAT_BATCH] != 0) {
            load_positions_scalar(f, (splat_lanes){first, count, NULL}, &batch);
            fragments += draw_square_batch(f, &batch, first, count);
        } else if (splats->hidden != NULL) {
            splats->hidden[first / SPLAT_BATCH] = 0;
        }
    }
    return fragments;
}

uint64_t stp_splats_squares_portable(const stp_splat_frame* frame);
uint64_t stp_splats_squares_vector(const stp_splat_frame* frame);
uint64_t stp_splats_squares_wide(const stp_splat_frame* frame);
