// SPDX-License-Identifier: MIT
// Merges the histories of all pieces into one order: the forest.
#pragma once

#include "lod/psp/rounds.h"

/// Makes the forest of the recorded merges. Merges are ordered by the largest error of the merge
/// and all merges below it, so that splats come before the merges that consume them; ties are in
/// order of creation.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); the caller destroys the forest
STP_MUST_USE stp_result stp_psp_order_merges(const stp_psp_rounds* rounds, stp_psp_forest* forest);
