// SPDX-License-Identifier: MIT
// Fills pieces with splats: from points in the first round, from blocks in later ones. Makes blocks
// of the remaining splats.
#pragma once

#include "lod/psp/rounds.h"

/// Fills a piece with slots [begin, end) of the round. @return false if out of memory
bool stp_psp_load(const stp_psp_rounds* rounds, stp_psp_piece* piece, uint32_t begin, uint32_t end);

/// Makes the block of a merged piece.
/// @param survivors receives for each slot of the piece the block index of the splat that
///         represents it
/// @return false if out of memory or disk space
bool stp_psp_unload(stp_psp_piece* piece, const stp_psp_room* room, stp_psp_block* block,
                    uint32_t* survivors);

/// Errors of the best merges of evenly sampled splats, ascending; disallowed merges are left out.
/// @param errors space for `maximum` values
/// @return their number
uint32_t stp_psp_sample_errors(const stp_psp_rounds* rounds, float* errors, uint32_t maximum);
