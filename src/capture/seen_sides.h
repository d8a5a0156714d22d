// SPDX-License-Identifier: MIT
//
// Which sides of the triangles of a part can be seen from outside, sampled by parallel projection
// from many directions. Triangles are opaque and hide each other from both sides.
//
//   pictures     each triangle that wins a pixel is seen on the side that faces the viewer
//   completion   triangles take the sides of seen ones close by, which pixels or directions missed
#pragma once

#include "base/core/context.h"

enum {
    STP_SEEN_FRONT = 1, ///< the side from which the corners turn counter-clockwise
    STP_SEEN_BACK = 2,
};

enum { STP_SEEN_RESOLUTION_MAX = 8192 };

/// Zero stands for a default.
typedef struct stp_seen_desc {
    uint32_t direction_count; ///< in opposite pairs: even, above 26; default 96
    /// Pixels along the diagonal of the bounding box, at most STP_SEEN_RESOLUTION_MAX; default 512.
    /// Smaller openings may be missed. A running task needs about 16 resolution^2 bytes, a call up
    /// to 48 bytes a triangle; 24 and 52 with triangles whose backs are not drawn. These views are
    /// drawn twice, with backs and without.
    uint32_t resolution;
    /// NULL, or one per triangle: not 0 if its back is not drawn. Sides then count as seen if they
    /// are where backs hide what is behind them, or where those of such triangles do not.
    const uint8_t* front_only;
} stp_seen_desc;

/// Finds the sides that can be seen. `positions`: 3 per vertex, finite, in any unit; welded, so
/// that triangles that touch share vertices. `indices`: 3 per triangle. `sides` receives a byte
/// for each triangle: 0 or STP_SEEN_* bits. The same result for any number of threads. May run
/// inside a parallel loop.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged; `sides` is undefined)
STP_MUST_USE stp_result stp_find_seen_sides(stp_context* context, const float* positions,
                                            uint32_t vertex_count, const uint32_t* indices,
                                            uint32_t triangle_count, const stp_seen_desc* desc,
                                            uint8_t* sides);
