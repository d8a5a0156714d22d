// SPDX-License-Identifier: MIT
//
// Growths of the points of a cloud: how far the surface around each point reaches, as one of a few
// factors on the candidate radius of its set. A splat names its growth by its shading.
#pragma once

#include "base/core/context.h"

enum {
    STP_GROWTHS = 13,     ///< factors: half powers of 2
    STP_GROWTH_PLAIN = 6, ///< index of the factor 1
    STP_GROWTH_SHADINGS = 256
};

/// Shadings that differ only in their growth.
typedef struct stp_growth_table {
    uint8_t of[STP_GROWTH_SHADINGS][STP_GROWTHS]; ///< per shading: the same with each growth
    uint8_t plain[STP_GROWTH_SHADINGS];           ///< per shading: the same without growth
} stp_growth_table;

/// The factor of an index.
float stp_growth_factor(uint32_t growth);

typedef struct stp_growth_desc {
    const float* positions; ///< 3 per point; of an exact order, in this order
    const float* normals;   ///< 3 per point, unit vectors
    uint32_t count;
    /// The first points, which lie at least `spacing` apart and cover all others to it; used for
    /// wide gaps. May be `count`.
    uint32_t sparse_count;
    float spacing; ///< of the points, above 0
    float covered; ///< distance that drawing covers around each point in any case
    float radius;  ///< candidate radius of the set, above 0
    bool smaller;  ///< whether factors below 1 are allowed
} stp_growth_desc;

/// Finds how far the surface reaches around each point: the farthest corner of its cell in the
/// Voronoi diagram of its neighbours in its tangent plane. In a direction in which the cell reaches
/// more than 1.3 times as far as on the opposite side, it counts at most `covered` + `radius`, so
/// that borders stay where they are; twice that where the cell is closed on that side. In a cell
/// that is closed on all sides, a direction counts up to twice as far as the opposite one. At most
/// `covered` plus the largest factor times `radius` is found. Factors above 1 are at most two steps
/// above the median of the other points of the cell of a grid, 2.5 spacings wide, but are never
/// limited below 1. A point alone there takes the cell of the next grid, 5 spacings wide, if that has
/// three others, or else has at most the factor 1.
/// @param growths result: an index for each point: the smallest factor that reaches as far
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_growths_find(stp_context* context, const stp_growth_desc* desc,
                                         uint8_t* growths);
