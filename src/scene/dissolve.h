// SPDX-License-Identifier: MIT
//
// Which children say nothing about place.
//
//   storey ─┬─ walls    (as wide as the storey)          storey ─┬─ a wall, a lamp and a pipe
//           ├─ lamps    (as wide)                  ->            ├─ a wall and two lamps
//           └─ pipes    (as wide)                                └─ ...
//
// Results of a build are kept by content, so what becomes of a node is decided by what is in it, and not by who else
// uses its children: a part changed elsewhere would change it, too. Only where that would repeat more
// shared things than there are things in the scene does it depend on the rest of the scene.
#pragma once

#include "scene/scene.h"

enum { STP_DISSOLVED = 1, STP_DISSOLVED_IN_ROOT = 2 };

/// Finds the edges whose child is dissolved into the parent: one of several things in it, as wide as it, not moving,
/// and no more than a few times as many things as there are beside it (else it is as good as the parent itself). And
/// those dissolved into the root that only stand between it and its content, turning or scaling a whole input: else
/// the whole would be approximated twice. An array of one byte an edge (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_dissolved(const stp_scene* scene, uint8_t** wide);
