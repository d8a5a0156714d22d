// SPDX-License-Identifier: MIT
//
// Tests each splat's range of levels, sixteen at a time (Dachsbacher et al. 2003, 3.6): branch-free
// loops that every variant compiles for its own instruction set.
#pragma once

#include "raster/splat_groups.h"
#include "raster/splats_kernel.h"

#include <assert.h>

/// Row of the depth after the position grid, and the levels.
typedef struct levels_frame {
    const stp_raster_splats* splats;
    const uint32_t* ranges;
    float w[4];
    stp_raster_levels levels;
    stp_raster_groups groups; ///< set if levels.groups is
} levels_frame;

/// One bit for each of sixteen splats whose range contains the level.
static inline uint32_t pick_sixteen(const levels_frame* restrict f, const float* restrict x,
                                    const float* restrict y, const float* restrict z,
                                    const uint32_t* restrict ranges)
{
    int32_t in[SPLAT_BATCH];
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float W = ((f->w[0] * x[i] + f->w[1] * y[i]) + f->w[2] * z[i]) + f->w[3];
        float level = f->levels.per_depth * W;
        level = level > f->levels.minimum ? level : f->levels.minimum;
        // the bits of positive floats sort like the floats
        int32_t bits = (int32_t)stp_bits_of_float(level);
        int32_t lowest = (int32_t)((ranges[i] & 0xFFFFu) << 15);
        int32_t highest = (int32_t)(ranges[i] >> 16 << 15);
        in[i] = (int32_t)(bits >= lowest) & (int32_t)(bits <= highest);
    }
    uint32_t bits = 0;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        bits |= (uint32_t)in[i] << i;
    }
    return bits;
}

/// Same as above, but splats before the divide are tested against the other level. Separate because
/// few pictures need it and it would make the loop above 50 % slower.
static inline uint32_t pick_below(const levels_frame* f, uint32_t first, const uint32_t* ranges,
                                  uint32_t picked)
{
    assert(first < f->levels.divide);
    uint32_t level = stp_bits_of_float(f->levels.below), count = f->levels.divide - first;
    for (uint32_t i = 0; i < SPLAT_BATCH && i < count; ++i) {
        bool in = level >= (ranges[i] & 0xFFFFu) << 15 && level <= ranges[i] >> 16 << 15;
        picked = (picked & ~(1u << i)) | (uint32_t)in << i;
    }
    return picked;
}

static inline bool pick_all(const levels_frame* f, uint16_t* bits)
{
    const stp_raster_splats* splats = f->splats;
    uint32_t any = 0;
    uint64_t left_out = 0; ///< bits of the group's splats that large triangles replace
    bool dropped = false;
    for (uint32_t first = splats->begin; first < splats->end; first += SPLAT_BATCH) {
        if (f->levels.groups != NULL && (first % STP_GROUP_SPLATS == 0 || first == splats->begin)) {
            const stp_splat_group* group = &f->levels.groups[first / STP_GROUP_SPLATS];
            left_out = f->levels.beside_triangles ? group->replaced : 0;
            dropped = left_out == UINT64_MAX || stp_raster_drops_group(&f->groups, group);
        }
        if (dropped) {
            bits[first / SPLAT_BATCH] = 0;
            continue;
        }
        uint32_t left = splats->end - first, count = left < SPLAT_BATCH ? left : SPLAT_BATCH;
        uint32_t wanted = count < SPLAT_BATCH ? (1u << count) - 1u : 0xFFFFu;
        wanted &= splats->wanted != NULL ? splats->wanted[first / SPLAT_BATCH] : 0xFFFFu;
        wanted &= ~(uint32_t)(left_out >> first % STP_GROUP_SPLATS);
        const uint16_t* positions = splats->positions + 3 * (size_t)first;
        float x[SPLAT_BATCH], y[SPLAT_BATCH], z[SPLAT_BATCH];
        uint32_t ranges[SPLAT_BATCH];
        for (uint32_t i = 0; i < SPLAT_BATCH; ++i) {
            uint32_t at = i < count ? i : 0;
            x[i] = (float)positions[3 * at];
            y[i] = (float)positions[3 * at + 1];
            z[i] = (float)positions[3 * at + 2];
            ranges[i] = f->ranges[first + at];
        }
        uint32_t picked = pick_sixteen(f, x, y, z, ranges);
        if (first < f->levels.divide) {
            picked = pick_below(f, first, ranges, picked);
        }
        wanted &= picked;
        bits[first / SPLAT_BATCH] = (uint16_t)wanted;
        any |= wanted;
    }
    return any != 0;
}

bool stp_splats_pick_portable(const levels_frame* frame, uint16_t* bits);
bool stp_splats_pick_avx2(const levels_frame* frame, uint16_t* bits);
bool stp_splats_pick_avx512(const levels_frame* frame, uint16_t* bits);
