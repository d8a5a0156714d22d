// SPDX-License-Identifier: MIT
// Places divided by planes into runs of about equal length.
#pragma once

#include "base/context.h"

/// Where a triangle or a point is.
typedef struct stp_place {
    float at[3];
    uint32_t index;
} stp_place;

/// Reorders `places` (indices differ) so that the i-th of `pieces` runs, from ends[i - 1] to ends[i] - 1, is a
/// region bounded by planes; within a run indices ascend. No run is longer than ceil(count / pieces). On all threads; the result
/// does not depend on them. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cut_ranges(stp_context* context, stp_place* places, uint32_t count,
                                       uint32_t pieces, uint32_t* ends);
