// SPDX-License-Identifier: MIT
// Fills pieces with splats: those of points in the first round, those of blocks later; and makes
// blocks of what is left.
#pragma once

#include "lod/psp/rounds.h"

/// Fills a piece with the slots [begin, end) of the round. @return false where memory runs out
bool stp_psp_load(const stp_psp_rounds* rounds, stp_psp_piece* piece, uint32_t begin, uint32_t end);

/// Makes the block of a piece that was merged.
/// @param survivors receives for each slot of the piece the place in the block of the splat that
///         stands for it
/// @return false where memory, or the room, runs out
bool stp_psp_unload(stp_psp_piece* piece, const stp_psp_room* room, stp_psp_block* block,
                    uint32_t* survivors);

/// The errors of the best merges of some splats, taken evenly; ascending, without those that are
/// not allowed.
/// @param errors room for `most`. @return how many
uint32_t stp_psp_sample_errors(const stp_psp_rounds* rounds, float* errors, uint32_t most);
