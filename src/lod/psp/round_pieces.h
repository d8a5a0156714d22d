// SPDX-License-Identifier: MIT
// Cuts the splats of a round into pieces, and carries links over the seams of the last round.
#pragma once

#include "lod/psp/rounds.h"

/// A range of slots.
typedef struct stp_psp_range {
    uint32_t begin, end;
} stp_psp_range;

/// Cuts all slots into pieces. The first round cuts subtrees of the kd-tree; later rounds cut at
/// other places and reorder the slots.
/// @param piece_size maximum splats per piece, above 0; STP_KD_LEAF splats are never cut
/// @param ranges receives the pieces; the caller frees them
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_cut_pieces(stp_psp_rounds* rounds, uint32_t piece_size,
                                           stp_psp_range** ranges, uint32_t* count);

/// Converts `survivors` to slots of the current round, after its order is final.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_renumber(stp_psp_rounds* rounds);

/// Discards all links and links each splat with its nearest ones, in both directions. All splats
/// must be in one block.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_relink(stp_psp_rounds* rounds);
