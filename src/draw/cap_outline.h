// SPDX-License-Identifier: MIT
// Outlines of a plane's cut, as unordered segments.
#pragma once

#include "base/core/context.h"

/// A segment of an outline. Seen from the side that is cut away, the solid is on its left.
typedef struct stp_cap_segment {
    float from[3], to[3]; ///< scene space, relative to the origin of the outlines
} stp_cap_segment;

typedef struct stp_cap_outline {
    stp_cap_segment* segments;
    size_t count, capacity;
} stp_cap_outline;

/// Ignores segments beyond four million. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_outline_add(stp_context* context, stp_cap_outline* outline,
                                            const float from[3], const float to[3]);

/// Connects loose ends, which arise where a plane cuts through a crack, to nearby ones, so that all
/// outlines are closed.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_outline_close(stp_context* context, stp_cap_outline* outline);
