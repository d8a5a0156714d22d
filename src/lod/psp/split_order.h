// SPDX-License-Identifier: MIT
// Split order of a merge forest, and the levels at which each splat is drawn (Wu, Zhang, Kobbelt
// 2005, section 5).
#pragma once

#include "lod/psp/forest.h"

/// Splats of a forest: first the roots, then the two parts of each merge, in the order of splits.
/// The merge with the highest level is split first.
typedef struct stp_psp_sequence {
    uint32_t count;
    uint32_t* splats; ///< numbers in the forest
    /// Codes (base/splats/splat_codes.h). The lowest level is 0 for samples and above 0 for merges
    uint32_t* ranges;
    float* highest_left; ///< highest level among a splat and all after it
} stp_psp_sequence;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_psp_sequence_destroy, also after
///         a failure
STP_MUST_USE stp_result stp_psp_sequence_make(stp_context* context, const stp_psp_forest* forest,
                                              stp_psp_sequence* sequence);
void stp_psp_sequence_destroy(stp_context* context, stp_psp_sequence* sequence);
