// SPDX-License-Identifier: MIT
// Cuts the splats of a round into pieces, and carries links over the seams of the last round.
#pragma once

#include "lod/psp/rounds.h"

/// Slots.
typedef struct stp_psp_range {
    uint32_t begin, end;
} stp_psp_range;

/// Cuts all slots into pieces. In the first round these are parts of the tree; later ones are cut
/// at other places in each round, and the order is rearranged.
/// @param piece_size the most splats of a piece, STP_KD_LEAF and more
/// @param ranges receives the pieces; the caller frees them. @return STP_OK,
///         STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_cut_pieces(stp_psp_rounds* rounds, uint32_t piece_size,
                                           stp_psp_range** ranges, uint32_t* count);

/// Makes `survivors` hold slots of the round to come, whose order is final. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_renumber(stp_psp_rounds* rounds);

/// Replaces the links of all splats, which are one block: each is linked with the nearest ones,
/// both ways.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_link_anew(stp_psp_rounds* rounds);
