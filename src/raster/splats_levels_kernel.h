// SPDX-License-Identifier: MIT
//
// Tests each splat's range of levels, sixteen at a time (Dachsbacher et al. 2003, 3.6): branch-free
// loops that every variant compiles for its own instruction set. With split errors, the direction
// to the eye lowers the levels of a range (3.7).
#pragma once

#include "base/splats/coverage.h"
#include "base/splats/splat_codes.h"
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
    float eye[3];             ///< set if levels.errors is (stp_raster_find_eye)
    float away;               ///< 1: sights begin at the eye; 0: all are `eye`, in parallel
} levels_frame;

/// Slightly less than the lowest share of a level that a view direction leaves.
#define LOWEST_SHARE (0.999f * (float)STP_ERROR_SHARE_FIRST / (float)STP_ERROR_STEPS)

/// Normals and errors of sixteen splats.
typedef struct splat_errors {
    float u[SPLAT_BATCH], v[SPLAT_BATCH];
    uint32_t codes[SPLAT_BATCH];
} splat_errors;

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

/// One bit for each of sixteen splats whose range contains the level, where the view direction
/// lowers both ends.
static inline uint32_t pick_directed(const levels_frame* restrict f, const float* restrict x,
                                     const float* restrict y, const float* restrict z,
                                     const uint32_t* restrict ranges,
                                     const splat_errors* restrict e)
{
    int32_t in[SPLAT_BATCH];
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float W = ((f->w[0] * x[i] + f->w[1] * y[i]) + f->w[2] * z[i]) + f->w[3];
        float level = f->levels.per_depth * W;
        level = level > 0.0f ? level : 0.0f;
        stp_vec3 sight = {f->eye[0] - f->away * x[i], f->eye[1] - f->away * y[i],
                          f->eye[2] - f->away * z[i]};
        uint32_t code = e->codes[i];
        float own = stp_error_share(code & 15u, code >> 4 & 15u,
                                    stp_octahedral_unfold(e->u[i], e->v[i]), sight);
        // 32 bits throughout, so that all lanes fit in few vectors
        float u = (float)((int32_t)(code << 8) >> 24), v = (float)((int32_t)code >> 24);
        float parent =
            stp_error_share(code >> 8 & 15u, code >> 12 & 15u, stp_octahedral_unfold(u, v), sight);
        float lowest = own * stp_range_level(ranges[i] & 0xFFFFu);
        float highest = parent * stp_range_level(ranges[i] >> 16);
        in[i] = (int32_t)(level >= lowest) & (int32_t)(level <= highest);
    }
    uint32_t bits = 0;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        bits |= (uint32_t)in[i] << i;
    }
    return bits;
}

/// Whether any of sixteen splats may be selected, in any view direction.
static inline bool may_pick(const levels_frame* restrict f, const float* restrict x,
                            const float* restrict y, const float* restrict z,
                            const uint32_t* restrict ranges)
{
    int32_t any = 0;
    for (int i = 0; i < SPLAT_BATCH; ++i) {
        float W = ((f->w[0] * x[i] + f->w[1] * y[i]) + f->w[2] * z[i]) + f->w[3];
        float level = f->levels.per_depth * W;
        level = level > 0.0f ? level : 0.0f;
        float lowest = LOWEST_SHARE * stp_range_level(ranges[i] & 0xFFFFu);
        any |= (int32_t)(level >= lowest) & (int32_t)(level <= stp_range_level(ranges[i] >> 16));
    }
    return any != 0;
}

/// Loads sixteen normals and codes of errors; lanes after the last repeat the first.
static inline void load_errors(const levels_frame* f, uint32_t first, uint32_t count,
                               splat_errors* e)
{
    const int8_t* normals = f->splats->normals + 2 * (size_t)first;
    const uint32_t* codes = f->levels.errors + first;
    for (uint32_t i = 0; i < SPLAT_BATCH; ++i) {
        uint32_t at = i < count ? i : 0;
        e->u[i] = (float)normals[2 * at];
        e->v[i] = (float)normals[2 * at + 1];
        e->codes[i] = codes[at];
    }
}

/// Same as pick_sixteen, but splats before the divide are tested against the other level. Separate
/// because few pictures need it and it would make the loop above 50 % slower.
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

static inline __attribute__((always_inline)) bool pick_each(const levels_frame* f, uint16_t* bits,
                                                            const bool directed)
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
        uint32_t picked = 0;
        if (!directed) {
            picked = pick_sixteen(f, x, y, z, ranges);
        } else if (may_pick(f, x, y, z, ranges)) {
            splat_errors errors;
            load_errors(f, first, count, &errors);
            picked = pick_directed(f, x, y, z, ranges, &errors);
        }
        if (first < f->levels.divide) {
            picked = pick_below(f, first, ranges, picked);
        }
        wanted &= picked;
        bits[first / SPLAT_BATCH] = (uint16_t)wanted;
        any |= wanted;
    }
    return any != 0;
}

static inline bool pick_all(const levels_frame* f, uint16_t* bits)
{
    return f->levels.errors != NULL ? pick_each(f, bits, true) : pick_each(f, bits, false);
}

bool stp_splats_pick_portable(const levels_frame* frame, uint16_t* bits);
bool stp_splats_pick_vector(const levels_frame* frame, uint16_t* bits);
bool stp_splats_pick_wide(const levels_frame* frame, uint16_t* bits);
