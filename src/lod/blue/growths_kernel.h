// SPDX-License-Identifier: MIT
// Cells in planes, several neighbours or directions at a time: compiled for CPUs with vectors of 16
// and 32 bytes. Each lane is a neighbour or a direction of its own, and a cell is the same in any
// order of cuts, so all variants give the same bits.
#pragma once

#include "lod/blue/growths_kernels.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#if defined(__AVX2__)
enum { LANES = 8 };
#else
enum { LANES = 4 };
#endif
enum { DIRECTIONS = STP_GROWTH_DIRECTIONS, PARTS = DIRECTIONS / LANES };

_Static_assert(STP_GROWTH_LANES % LANES == 0, "lists are read in whole vectors");

#define STEEP 1.0f // neighbours may lie this far from the plane, relative to their distance in it
#define BETWEEN 1.05f    // corners of a cell may lie between two directions
#define ONE_SIDED 1.3f   // how much farther a cell may reach than on its opposite side
#define INNER_SIDED 2.0f // the same for an enclosed cell

typedef float lanes_float __attribute__((vector_size(4 * LANES)));
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES)));

static const float cosines[DIRECTIONS] = {
    1.0f,  0.92387953f,  0.70710678f,  0.38268343f,  0.0f, -0.38268343f, -0.70710678f, -0.92387953f,
    -1.0f, -0.92387953f, -0.70710678f, -0.38268343f, 0.0f, 0.38268343f,  0.70710678f,  0.92387953f};
static const float sines[DIRECTIONS] = {0.0f,  0.38268343f,  0.70710678f,  0.92387953f,
                                        1.0f,  0.92387953f,  0.70710678f,  0.38268343f,
                                        0.0f,  -0.38268343f, -0.70710678f, -0.92387953f,
                                        -1.0f, -0.92387953f, -0.70710678f, -0.38268343f};

// Vectors are passed by address: without AVX2, compilers do not agree how to pass them by value.

/// Sets `to` to the larger values.
static inline void raise(lanes_float* to, const lanes_float* values)
{
#if defined(__AVX2__)
    *to = (lanes_float)_mm256_max_ps((__m256)*to, (__m256)*values);
#elif defined(__x86_64__)
    *to = (lanes_float)_mm_max_ps((__m128)*to, (__m128)*values);
#else
    lanes_int kept = (lanes_int)(*to > *values);
    *to = (lanes_float)(((lanes_int)*to & kept) | ((lanes_int)*values & ~kept));
#endif
}

/// The lanes that are -1, as bits.
static inline uint32_t bits_of(const lanes_int* set)
{
#if defined(__AVX2__)
    return (uint32_t)_mm256_movemask_ps((__m256)*set);
#elif defined(__x86_64__)
    return (uint32_t)_mm_movemask_ps((__m128)*set);
#else
    uint32_t bits = 0;
    for (int k = 0; k < LANES; ++k) {
        bits |= (uint32_t)((*set)[k] & 1 << k);
    }
    return bits;
#endif
}

/// The least of all directions.
static inline float least_of(const float values[DIRECTIONS])
{
    float eight[8], four[4];
    for (int k = 0; k < 8; ++k) {
        eight[k] = stp_min(values[k], values[k + 8]);
    }
    for (int k = 0; k < 4; ++k) {
        four[k] = stp_min(eight[k], eight[k + 4]);
    }
    return stp_min(stp_min(four[0], four[1]), stp_min(four[2], four[3]));
}

/// Offsets from a point to others.
static inline void load_offsets(const stp_around* around, uint32_t at, const stp_vec3* point,
                                lanes_float offsets[3])
{
    memcpy(&offsets[0], around->x + at, sizeof(offsets[0]));
    memcpy(&offsets[1], around->y + at, sizeof(offsets[1]));
    memcpy(&offsets[2], around->z + at, sizeof(offsets[2]));
    offsets[0] -= point->x;
    offsets[1] -= point->y;
    offsets[2] -= point->z;
}

/// Places of points in the plane of a cell.
typedef struct plane_places {
    _Alignas(32) float u[STP_AROUND_MAX];
    _Alignas(32) float v[STP_AROUND_MAX];
    _Alignas(32) float square[STP_AROUND_MAX]; ///< of the distance; INFINITY: does not cut
} plane_places;

/// Projects points into the plane of a cell. @return the steep ones
static uint32_t project(const stp_around* around, const stp_plane_cell* cell, float steep_within,
                        plane_places* places)
{
    stp_vec3 point = cell->point, across = cell->across, along = cell->along, n = cell->normal;
    const lanes_float far = (lanes_float){0} + INFINITY;
    lanes_int steep = {0};
    for (uint32_t i = 0; i < around->count; i += LANES) {
        lanes_float d[3];
        load_offsets(around, i, &point, d);
        lanes_float u = d[0] * across.x + d[1] * across.y + d[2] * across.z;
        lanes_float v = d[0] * along.x + d[1] * along.y + d[2] * along.z;
        lanes_float h = d[0] * n.x + d[1] * n.y + d[2] * n.z;
        lanes_float square = u * u + v * v, climb = h * h;
        lanes_int near =
            (lanes_int)(climb <= STEEP * STEEP * square) & (lanes_int)(square >= FLT_MIN);
        steep -= (lanes_int)(climb > STEEP * STEEP * square) &
                 (lanes_int)(square + climb < steep_within);
        square = (lanes_float)(((lanes_int)square & near) | ((lanes_int)far & ~near));
        memcpy(places->u + i, &u, sizeof(u));
        memcpy(places->v + i, &v, sizeof(v));
        memcpy(places->square + i, &square, sizeof(square));
    }
    uint32_t sum = 0;
    for (int k = 0; k < LANES; ++k) {
        sum += (uint32_t)steep[k];
    }
    return sum;
}

/// Cuts a cell by the points whose squared distances are in [from, to).
static void cut_band(const plane_places* places, uint32_t count, float from, float to,
                     stp_plane_cell* cell)
{
    lanes_float nearness[PARTS], cosine[PARTS], sine[PARTS];
    memcpy(nearness, cell->nearness, sizeof(nearness));
    memcpy(cosine, cosines, sizeof(cosine));
    memcpy(sine, sines, sizeof(sine));
    for (uint32_t i = 0; i < count; i += LANES) {
        lanes_float square;
        memcpy(&square, places->square + i, sizeof(square));
        lanes_int near = (lanes_int)(square >= from) & (lanes_int)(square < to);
        for (uint32_t bits = bits_of(&near); bits != 0; bits &= bits - 1) {
            uint32_t at = i + (uint32_t)__builtin_ctz(bits);
            float scale = 2.0f / places->square[at];
            float a = places->u[at] * scale, b = places->v[at] * scale;
            for (int k = 0; k < PARTS; ++k) {
                lanes_float own = a * cosine[k] + b * sine[k];
                raise(&nearness[k], &own);
            }
        }
    }
    memcpy(cell->nearness, nearness, sizeof(nearness));
    cell->least = stp_max(least_of(cell->nearness), 0.0f);
    cell->beyond = cell->least > 0.0f ? 4.0f / (cell->least * cell->least) : INFINITY;
}

static void cut(const stp_around* around, float from, float to, float steep_within,
                stp_plane_cell* cell)
{
    enum { BANDS = 4 };
    assert(around->count % LANES == 0 && around->count <= STP_AROUND_MAX);
    plane_places places;
    cell->steep += project(around, cell, steep_within, &places);
    for (int band = 0; band < BANDS && from < cell->beyond; ++band) {
        to = band + 1 < BANDS ? stp_min(to, cell->beyond) : cell->beyond;
        cut_band(&places, around->count, from, to, cell);
        from = to;
        to *= 4.0f;
    }
}

static float reach(const stp_cell_limits* limits, const stp_plane_cell* cell)
{
    float ring[2 * DIRECTIONS], reaches[DIRECTIONS];
    memcpy(ring, cell->nearness, sizeof(cell->nearness));
    memcpy(ring + DIRECTIONS, cell->nearness, sizeof(cell->nearness));
    const float *own = ring + DIRECTIONS / 2, *opposite = ring + DIRECTIONS;
    stp_cell_limits l = *limits;
    float sided = cell->least >= l.enclosed ? INNER_SIDED : ONE_SIDED;
#pragma GCC unroll 1
    for (int k = 0; k < DIRECTIONS; ++k) { // compiled to vectors, unless it is unrolled first
        float beside = stp_min(own[k - 1], own[k + 1]);
        float distance = BETWEEN / own[k], other = sided / opposite[k];
        float limit = stp_min(own[k], beside) >= l.closed ? l.hole : l.plain;
        distance = own[k] > 0.0f ? distance : INFINITY;
        other = opposite[k] > 0.0f ? other : 0.0f;
        limit = stp_min(stp_max(limit, other), l.most);
        reaches[k] = -stp_min(distance, limit);
    }
    return -least_of(reaches);
}
