// SPDX-License-Identifier: MIT
// Divides places by planes into runs of about equal length.
#pragma once

#include "base/core/context.h"

/// Position of a triangle or a point.
typedef struct stp_place {
    float at[3];
    uint32_t index;
} stp_place;

/// Reorders `places` (with distinct indices below `count`) so that run i of `pieces`, from
/// ends[i - 1] to ends[i] - 1, is a region bounded by planes; within a run, indices ascend. No run
/// is longer than ceil(count / pieces). Uses all threads; the result does not depend on their
/// number.
/// `in_spill`: the places lie in a spill, of which little is to be resident.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cut_ranges(stp_context* context, stp_place* places, uint32_t count,
                                       uint32_t pieces, bool in_spill, uint32_t* ends);
