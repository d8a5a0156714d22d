// SPDX-License-Identifier: MIT
//
// Turns an order of candidates into surfels: positions on a grid, octaves, the colour pyramid,
// coverage, and the tables that choose prefixes (docs/algorithms/finish.md).
#pragma once

#include "base/splats/splat_columns.h"
#include "capture/capture.h"
#include "lod/blue/growths.h"

typedef struct stp_finish_input {
    const stp_candidates* candidates;
    const uint32_t* order; ///< candidate of each surfel; `count` of them, at least 1
    const float* radii;    ///< insertion radii; the first is infinite
    uint32_t count;
    float final_radius; ///< distance of the farthest candidate to the order
    const uint8_t* shading_of_material;
    const stp_growth_table* growths; ///< NULL: all splats of a set are alike
    float spacing;                   ///< of points; 0: not points, or they have none
    bool exact;                      ///< insertion radii never increase
    bool two_sided; ///< ignores the sign of normals, which is estimated in point clouds
    bool by_side;   ///< the order is side-aware: surfels that face apart are no neighbours
} stp_finish_input;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (logged); `surfels` is empty after
/// a failure
STP_MUST_USE stp_result stp_finish_surfels(stp_context* context, const stp_finish_input* input,
                                           stp_splats* surfels);

// Its parts, one file each:

/// Grid for positions in a box of node space: the smallest power-of-two step, at least `min_step`,
/// with which 65,535 steps span the box, and an origin on the grid that a float represents exactly.
/// Neighbouring pieces with the same step therefore round to the same positions.
void stp_choose_position_grid(stp_boxd box, double min_step, stp_vec3* origin, float* step);

/// Splits an order into octaves, from its end: the last octave ends with the last surfel, the
/// previous one where disks are twice as large, and so on. `envelope[i]` is the coverage radius of
/// the first i; disks are larger by `margin`. Leaves out octaves whose disks have more than
/// `area_limit` together: in an uneven order, a prefix of most points may still cover with large
/// disks only, each of which would hold most of the surface. @return the number of octaves
uint32_t stp_choose_octaves(const float* envelope, float margin, double area_limit, uint32_t count,
                            uint32_t ends[STP_OCTAVE_LIMIT]);

/// Median distance to the nearest neighbour (Brandt 4.1), of 200 points. With normals (NULL: none),
/// points that face apart are no neighbours, as in a side-aware order, which covers both sides of a
/// wall.
float stp_median_spacing(const float* positions, const float* normals, uint32_t count);

/// Inputs and output of the pyramid.
typedef struct stp_pyramid_input {
    const stp_finish_input* finish;
    const float* positions; ///< 3 per surfel, relative to the candidates' origin
    const float* normals;   ///< 3 per surfel
    const float* envelope;  ///< coverage radius of the first i surfels
    float candidate_radius;
} stp_pyramid_input;

/// Fills colours and coverages of all octaves (`surfels` has counts, octaves and arrays).
STP_MUST_USE stp_result stp_make_pyramid(stp_context* context, const stp_pyramid_input* input,
                                         stp_splats* surfels);
