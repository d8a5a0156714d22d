// SPDX-License-Identifier: MIT
// Sets of method `psp`: a merge forest over a node's samples, stored as splats with shapes and
// ranges of levels.
//
// The order of a set implies its forest. The base set comes first; then each split adds two splats
// that replace an earlier one. Splits are ordered by falling lowest level of the replaced splats;
// on ties, the earlier splat is split first. So the first n splats contain the states of all
// smaller counts, and only ranges need to be stored.
#pragma once

#include "lod/psp/forest.h"

#include <stipple/surfels.h>

enum { STP_PSP_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS };

/// Makes the splats of a node by merging its evenly spread samples: a set of method `blue`. A splat
/// is drawn if the coverage radius wanted by the view lies within its range.
/// @param two_sided the signs of the samples' normals are a guess: samples that face away from each
/// other may be merged
/// @param splats arrays come from stp_alloc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make(stp_context* context, const stp_splats* samples,
                                     bool two_sided, stp_splats* splats);

/// The same with a given metric; sets of the method use STP_PSP_REGIONS.
STP_MUST_USE stp_result stp_psp_make_by(stp_context* context, const stp_splats* samples,
                                        bool two_sided, stp_psp_metric metric, stp_splats* splats);
