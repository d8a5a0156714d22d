// SPDX-License-Identifier: MIT
//
// Main loop of the vector variants, sixteen splats at a time. Included once by each variant, after
// its own load_positions, load_normals (sixteen splats each), lanes_of, draw_small and draw_wide.
#pragma once

#include "raster/splats_hidden.h"

#include <assert.h>

/// Draws a batch whose positions are loaded. Marks hidden splats.
static inline uint64_t draw_batch(const stp_splat_frame* f, splat_batch* t, splat_lanes lanes)
{
    const stp_raster_splats* splats = f->splats;
    uint64_t fragments = 0;
    load_shapes(f, lanes, t);
    load_parts(f, lanes, t);
    project_batch(f, t);
    pick_batch(f, t, lanes);
    if (splats->hidden != NULL && lanes.queued == NULL) {
        splats->hidden[lanes.first / SPLAT_BATCH] = (uint16_t)lanes_of(t, SPLAT_HIDDEN);
    } else if (splats->hidden != NULL) {
        for (uint32_t left = lanes_of(t, SPLAT_HIDDEN); left != 0; left &= left - 1) {
            uint32_t index = lanes.queued[__builtin_ctz(left)];
            uint32_t bit = 1u << index % SPLAT_BATCH;
            assert(index >= splats->begin && index < splats->end);
            splats->hidden[index / SPLAT_BATCH] |= (uint16_t)bit;
        }
    }
    uint32_t all = lanes_of(t, SPLAT_PIXEL);
    for (uint32_t pixels = all; pixels != 0; pixels &= pixels - 1) {
        int i = __builtin_ctz(pixels);
        fragments += draw_pixel(f, t, i, lane_splat(lanes, (uint32_t)i));
    }
    if (lanes_of(t, SPLAT_DISK) != 0) {
        if (splats->normals != NULL && lanes.queued == NULL && lanes.count == SPLAT_BATCH) {
            load_normals(splats->normals + 2 * (size_t)lanes.first, t);
        } else if (splats->normals != NULL) {
            load_normals_scalar(f, lanes, t);
        }
        shape_batch(f, t);
        stretch_batch(f, t);
        clip_batch(f, t);
        box_batch(t);
        sort_batch(f, t);
        uint32_t smalls = lanes_of(t, SPLAT_SMALL), wides = lanes_of(t, SPLAT_WIDE);
        all |= smalls | wides;
        fetch_small(f, t, smalls);
        for (uint32_t small = smalls; small != 0; small &= small - 1) {
            int i = __builtin_ctz(small);
            fragments += draw_small(f, t, i, lane_splat(lanes, (uint32_t)i));
        }
        for (uint32_t wide = wides; wide != 0; wide &= wide - 1) {
            int i = __builtin_ctz(wide);
            fragments += draw_wide(f, t, i, lane_splat(lanes, (uint32_t)i));
        }
    }
    uint32_t larges = lanes_of(t, SPLAT_LARGE);
    for (uint32_t large = larges; large != 0; large &= large - 1) {
        fragments += stp_splats_draw_large(f, lane_splat(lanes, (uint32_t)__builtin_ctz(large)));
    }
    count_drawn(splats, all | larges);
    return fragments;
}

static uint64_t draw_queued(const stp_splat_frame* f, splat_batch* t, const waiting_splats* w)
{
    const splat_lanes lanes = {0, w->count, w->index};
    load_positions_scalar(f, lanes, t);
    return draw_batch(f, t, lanes);
}

/// Draws the wanted splats. Where some of sixteen in a row are not wanted, the others wait until
/// there are sixteen of them.
static uint64_t draw_wanted(const stp_splat_frame* f, splat_batch* t)
{
    const stp_raster_splats* splats = f->splats;
    uint64_t fragments = 0;
    waiting_splats w = {.count = 0};
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        uint32_t wanted = splats->wanted[first / SPLAT_BATCH];
        if (wanted == 0xFFFFu && left >= SPLAT_BATCH) {
            load_positions(splats->positions + 3 * (size_t)first, t);
            fragments += draw_batch(f, t, (splat_lanes){first, SPLAT_BATCH, NULL});
            continue;
        }
        if (splats->hidden != NULL) {
            splats->hidden[first / SPLAT_BATCH] = 0;
        }
        wanted &= left < SPLAT_BATCH ? (1u << left) - 1u : 0xFFFFu;
        for (; wanted != 0; wanted &= wanted - 1) {
            assert(w.count < SPLAT_BATCH);
            w.index[w.count++] = first + (uint32_t)__builtin_ctz(wanted);
            if (w.count == SPLAT_BATCH) {
                fragments += draw_queued(f, t, &w);
                w.count = 0;
            }
        }
    }
    return w.count > 0 ? fragments + draw_queued(f, t, &w) : fragments;
}

static uint64_t draw_all(const stp_splat_frame* frame)
{
    const stp_raster_splats* splats = frame->splats;
    uint64_t fragments = 0;
    splat_batch batch = empty_batch();
    if (splats->wanted != NULL && splats->positions != NULL) {
        return draw_wanted(frame, &batch);
    }
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        uint32_t left = splats->end - first;
        splat_lanes lanes = {first, left < SPLAT_BATCH ? left : SPLAT_BATCH, NULL};
        if (skip_unwanted(splats, first)) {
            continue;
        }
        if (splats->positions != NULL && lanes.count == SPLAT_BATCH) {
            load_positions(splats->positions + 3 * (size_t)first, &batch);
        } else {
            load_positions_scalar(frame, lanes, &batch);
        }
        fragments += draw_batch(frame, &batch, lanes);
    }
    return fragments;
}
