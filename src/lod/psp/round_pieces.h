// SPDX-License-Identifier: MIT
// Cuts the splats of a round into pieces, and carries links over the seams of the last round.
#pragma once

#include "lod/psp/rounds.h"

/// Slots.
typedef struct stp_psp_range {
    uint32_t begin, end;
} stp_psp_range;

/// Cuts all slots into pieces. In the first round these are parts of the tree; later rounds cut at
/// different places and rearrange the order.
/// @param piece_size maximum splats per piece, at least STP_KD_LEAF
/// @param ranges receives the pieces; the caller frees them. @return STP_OK,
///         STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_cut_pieces(stp_psp_rounds* rounds, uint32_t piece_size,
                                           stp_psp_range** ranges, uint32_t* count);

/// Converts `survivors` to slots of the next round, whose order is final. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_renumber(stp_psp_rounds* rounds);

/// Replaces the links of all splats, which form one block: links each with the nearest ones, in
/// both directions.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_link_anew(stp_psp_rounds* rounds);
