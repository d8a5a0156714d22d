// SPDX-License-Identifier: MIT
// Sets of method `psp`: a merge forest over a node's samples, stored as splats with shapes and
// ranges of levels.
//
// The forest follows from the order of a set. The base set comes first; then each split adds two
// splats that replace an earlier one. Splats with a higher lowest level are split first; ties split
// the earlier splat first. So the first n splats contain the states of all smaller counts, and only
// ranges are stored.
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/psp/forest.h"

enum { STP_PSP_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS };

/// Makes the splats of a node by merging its evenly spaced samples, a set of method `blue`. A splat
/// is drawn if the coverage radius requested by the view lies in its range.
/// @param two_sided whether the signs of the samples' normals are a guess: samples that face away
/// from each other may then be merged
/// @param metric which pairs are merged, and the ellipses of merges. Ranges are differences of
/// pictures with any metric (region.h)
/// @param shadings of the samples: a sample that is drawn by itself has its growth; NULL: none
/// @param limit the finest state has at most this many splats, or those of the base set where they
/// are more; 0: no limit
/// @param splats arrays come from stp_alloc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make(stp_context* context, const stp_splats* samples,
                                     const stp_shading* shadings, bool two_sided,
                                     stp_psp_metric metric, uint32_t limit, stp_splats* splats);
