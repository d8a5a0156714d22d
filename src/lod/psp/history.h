// SPDX-License-Identifier: MIT
// Puts the merges of all pieces in one order: the forest.
#pragma once

#include "lod/psp/rounds.h"

/// Makes the forest of the merges that were recorded. Merges are ordered by the largest error of
/// the merge and of all below it, so that splats come before what they become; of equal ones, the
/// one made first comes first.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); the caller destroys the forest
STP_MUST_USE stp_result stp_psp_order_merges(const stp_psp_rounds* rounds, stp_psp_forest* forest);
