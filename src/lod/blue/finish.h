// SPDX-License-Identifier: MIT
//
// From an order of candidates to surfels: positions on a grid, octaves, the colour pyramid,
// coverage, and the tables that choose prefixes (design.md, Finish).
#pragma once

#include "capture/capture.h"

#include <stipple/surfels.h>

typedef struct stp_finish_input {
    const stp_candidates* candidates;
    const uint32_t* order; ///< the candidate of each surfel; `count` of them, at least 1
    const float* radii;    ///< insertion radii; the first is infinite
    uint32_t count;
    float final_radius; ///< distance of the farthest candidate to the order
    const uint8_t* shading_of_material;
    bool two_sided; ///< normals do not tell sides apart: point clouds, where their sign is a guess
} stp_finish_input;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED; `surfels` is then empty
STP_MUST_USE stp_result stp_finish_surfels(stp_context* context, const stp_finish_input* input,
                                           stp_splats* surfels);

// Its parts, each a file:

/// The grid for positions in a box of the node's space: the smallest power of two that 65,535 steps
/// of which reach across, and an origin on the grid that a float holds exactly. Neighbouring pieces
/// with the same step therefore round to the same places.
void stp_choose_position_grid(stp_boxd box, double least_step, stp_vec3* origin, float* step);

/// Cuts an order into octaves, counted from its end: the last octave ends with the last surfel, the
/// one before where disks are twice as large, and so on. `envelope[i]` is to what the first i cover;
/// disks are larger by `margin`. @return the number of octaves
uint32_t stp_choose_octaves(const float* envelope, float margin, uint32_t count,
                            uint32_t ends[STP_OCTAVE_LIMIT]);

/// The median distance to the nearest neighbour within the points (Brandt 4.1), of 200 of them.
float stp_median_spacing(const float* positions, uint32_t count);

/// What the pyramid is made from and into.
typedef struct stp_pyramid_input {
    const stp_finish_input* finish;
    const float* positions; ///< of the surfels, 3 each, as the candidates'
    const float* normals;   ///< of the surfels, 3 each
    const float* envelope;
    float candidate_radius;
} stp_pyramid_input;

/// Fills colours and coverages of all octaves (`surfels` has counts, octaves and arrays).
STP_MUST_USE stp_result stp_make_pyramid(stp_context* context, const stp_pyramid_input* input,
                                         stp_splats* surfels);
