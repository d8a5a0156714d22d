// SPDX-License-Identifier: MIT
// Sets of method `psp`: a merge forest over a node's samples, stored as splats with shapes and
// ranges of levels.
//
// The order of a set implies its forest. The base set comes first; then each split adds two splats,
// which replace an earlier one. Splits follow the lowest levels of the splats that they replace,
// falling; of equal ones the earlier splat is split first. So the first n splats hold the state
// with any smaller count, and nothing but ranges is stored.
#pragma once

#include "lod/psp/forest.h"

#include <stipple/surfels.h>

enum { STP_PSP_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS };

/// Makes the splats of a node by merging its evenly spread samples: a set of method `blue`. A splat
/// is drawn where the coverage radius that the view wants lies within its range.
/// @param splats arrays come from stp_alloc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make(stp_context* context, const stp_splats* samples,
                                     stp_splats* splats);

/// The same by a metric; sets of the method are made by STP_PSP_REGIONS.
STP_MUST_USE stp_result stp_psp_make_by(stp_context* context, const stp_splats* samples,
                                        stp_psp_metric metric, stp_splats* splats);
