// SPDX-License-Identifier: MIT
// Sets of method `stochastic`: all points of a cloud, or a random choice of a mesh's candidates, ordered leaf by leaf of an
// octree and at random within each leaf, so that a view takes from each leaf as many as it is worth (Bhakar, Luo, Mudur 2004).
#pragma once

#include "capture/capture.h"
#include "lod/stochastic/leaf_octree.h"

enum { STP_STOCHASTIC_COLUMNS = STP_SPLATS_SHAPES | STP_SPLATS_FLAT_COLORS };

/// What a set is made of.
typedef struct stp_stochastic_source {
    stp_candidates* candidates; ///< what is chosen of them moves to the front; normals may change
    const uint8_t*
        coverages; ///< codes, 1 a candidate, all of which are wanted; NULL: from the colours' alpha
    const uint8_t* shading_of_material;
    uint32_t wanted;  ///< most splats
    bool has_normals; ///< with signs; else they are estimated
} stp_stochastic_source;

/// @param splats arrays come from stp_alloc; without splats where there are no candidates
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_stochastic_make_set(stp_context* context,
                                                const stp_stochastic_source* source,
                                                const stp_leaf_desc* desc, stp_splats* splats);

/// The same of a set of method `blue`, all of it.
/// @param two_sided the signs of its normals are a guess
STP_MUST_USE stp_result stp_stochastic_make_of_samples(stp_context* context,
                                                       const stp_splats* samples, bool two_sided,
                                                       const stp_leaf_desc* desc,
                                                       stp_splats* splats);
