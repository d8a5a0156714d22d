// SPDX-License-Identifier: MIT
// Sets of method `stochastic`: all points of a cloud, or a random sample of a mesh's candidates.
// They are ordered by octree leaf, the first ones of each leaf evenly spread and the others at
// random, so that a view draws as many splats of each leaf as it needs (Bhakar, Luo, Mudur 2004).
#pragma once

#include "capture/capture.h"
#include "lod/stochastic/leaf_octree.h"

enum { STP_STOCHASTIC_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_FLAT_COLORS };

/// Input of a set.
typedef struct stp_stochastic_source {
    stp_candidates* candidates; ///< read; normals are set if `has_normals` is false
    /// Coverage codes, 1 per candidate, if all are wanted; NULL: from the colours' alpha
    const uint8_t* coverages;
    const uint8_t* shading_of_material;
    uint32_t wanted;  ///< maximum splats
    bool has_normals; ///< with signs; otherwise normals are estimated
} stp_stochastic_source;

/// @param splats arrays come from stp_alloc; empty if there are no candidates
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_stochastic_make_set(stp_context* context,
                                                const stp_stochastic_source* source,
                                                const stp_leaf_desc* desc, stp_splats* splats);

/// The same from all splats of a set of method `blue`.
/// @param two_sided the signs of its normals are unknown
STP_MUST_USE stp_result stp_stochastic_make_of_samples(stp_context* context,
                                                       const stp_splats* samples, bool two_sided,
                                                       const stp_leaf_desc* desc,
                                                       stp_splats* splats);
