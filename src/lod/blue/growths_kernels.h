// SPDX-License-Identifier: MIT
// Cells of points in the planes of their surfaces, and their neighbours. Every variant gives the
// same bits.
#pragma once

#include "base/math/math.h"

#include <stdint.h>

enum {
    STP_GROWTH_DIRECTIONS = 16,
    STP_GROWTH_LANES = 8,         ///< neighbours tested together
    STP_AROUND_MAX = 27 * 32 + 8, ///< all neighbours, and one vector
};

/// Points that may be near others.
typedef struct stp_around {
    uint32_t count; ///< a multiple of STP_GROWTH_LANES: padded with points infinitely far away
    float x[STP_AROUND_MAX], y[STP_AROUND_MAX], z[STP_AROUND_MAX];
} stp_around;

/// A point, the plane of its surface, and the cell around it.
typedef struct stp_plane_cell {
    stp_vec3 point, normal, across, along;
    _Alignas(32) float nearness[STP_GROWTH_DIRECTIONS]; ///< 1 / distance to the border; <= 0: none
    float least;                                        ///< the least nearness, or 0
    float beyond;   ///< squared distance in the plane from which neighbours change nothing
    uint32_t steep; ///< neighbours that are not of the surface
} stp_plane_cell;

/// How far a finished cell counts.
typedef struct stp_cell_limits {
    float plain;    ///< where nothing is opposite
    float closed;   ///< nearness from which a direction is closed
    float hole;     ///< how far it then counts
    float enclosed; ///< least nearness from which a cell has no border of the surface
    float most;     ///< how far any direction counts
} stp_cell_limits;

typedef struct stp_growth_kernels {
    /// Cuts a cell by the bisectors between its point and others that are farther away in its plane
    /// than a distance, the nearest first: those up to `to`, and so on by factors of 2. Points
    /// steeply above or below it do not cut; within a distance, they count as steep. All distances
    /// are squared.
    void (*cut)(const stp_around* around, float from, float to, float steep_within,
                stp_plane_cell* cell);
    /// How far a finished cell reaches, without what may be beyond the border of a surface.
    float (*reach)(const stp_cell_limits* limits, const stp_plane_cell* cell);
} stp_growth_kernels;

/// The kernels for this CPU.
const stp_growth_kernels* stp_growth_kernels_select(void);

extern const stp_growth_kernels stp_growth_kernels_portable;
extern const stp_growth_kernels stp_growth_kernels_vector;
