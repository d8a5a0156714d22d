// SPDX-License-Identifier: MIT
//
// Main loop of the vector variants, sixteen splats at a time. Included once by each variant, after
// its own load_positions, load_normals (sixteen splats each), lanes_of, draw_small and draw_wide.
#pragma once

#include "raster/splats_hidden.h"

/// Draws splats first .. first + 15; only the first `count` exist.
static inline uint64_t draw_batch(const stp_splat_frame* f, splat_batch* t, uint32_t first,
                                  uint32_t count)
{
    const stp_raster_splats* splats = f->splats;
    uint64_t fragments = 0;
    load_shapes(f, first, count, t);
    load_parts(f, first, count, t);
    project_batch(f, t);
    pick_batch(f, t, first, count);
    if (splats->hidden != NULL) {
        splats->hidden[first / SPLAT_BATCH] = (uint16_t)lanes_of(t, SPLAT_HIDDEN);
    }
    for (uint32_t pixels = lanes_of(t, SPLAT_PIXEL); pixels != 0; pixels &= pixels - 1) {
        int i = __builtin_ctz(pixels);
        fragments += draw_pixel(f, t, i, first + (uint32_t)i);
    }
    if (lanes_of(t, SPLAT_DISK) != 0) {
        if (splats->normals != NULL && count == SPLAT_BATCH) {
            load_normals(splats->normals + 2 * (size_t)first, t);
        } else if (splats->normals != NULL) {
            load_normals_scalar(f, first, count, t);
        }
        shape_batch(f, t);
        stretch_batch(f, t);
        cut_batch(f, t);
        box_batch(t);
        sort_batch(f, t);
        uint32_t smalls = lanes_of(t, SPLAT_SMALL);
        fetch_small(f, t, smalls);
        for (uint32_t small = smalls; small != 0; small &= small - 1) {
            int i = __builtin_ctz(small);
            fragments += draw_small(f, t, i, first + (uint32_t)i);
        }
        for (uint32_t wide = lanes_of(t, SPLAT_WIDE); wide != 0; wide &= wide - 1) {
            int i = __builtin_ctz(wide);
            fragments += draw_wide(f, t, i, first + (uint32_t)i);
        }
    }
    for (uint32_t large = lanes_of(t, SPLAT_LARGE); large != 0; large &= large - 1) {
        fragments += stp_splats_draw_large(f, first + (uint32_t)__builtin_ctz(large));
    }
    return fragments;
}

static uint64_t draw_all(const stp_splat_frame* frame)
{
    const stp_raster_splats* splats = frame->splats;
    uint64_t fragments = 0;
    splat_batch batch = empty_batch();
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        uint32_t count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        if (skip_unwanted(splats, first)) {
            continue;
        }
        if (splats->positions != NULL && count == SPLAT_BATCH) {
            load_positions(splats->positions + 3 * (size_t)first, &batch);
        } else {
            load_positions_scalar(frame, first, count, &batch);
        }
        fragments += draw_batch(frame, &batch, first, count);
    }
    return fragments;
}
