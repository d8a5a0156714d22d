// SPDX-License-Identifier: MIT
//
// Finds children that are as large as their parent, and so carry no spatial information.
//
//   storey ─┬─ walls    (as wide as the storey)          storey ─┬─ a wall, a lamp and a pipe
//           ├─ lamps    (as wide)                  ->            ├─ a wall and two lamps
//           └─ pipes    (as wide)                                └─ ...
//
// Build results are cached by content, so the result for a node must depend only on its content,
// not on other users of its children: otherwise a change elsewhere would change it, too. It depends
// on the rest of the scene only if dissolving would duplicate more shared items than the scene has.
#pragma once

#include "scene/scene.h"

enum { STP_DISSOLVED = 1, STP_DISSOLVED_IN_ROOT = 2 };

/// Finds the edges whose child is dissolved into the parent: one of several items in it, as large
/// as the parent, not moving, and with at most a few times as many items as the rest (otherwise it
/// is nearly the parent itself). Also the edges between the root and its content that only rotate
/// or scale a whole input; otherwise the whole scene would be approximated twice. `wide`: one byte
/// per edge (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_dissolved(const stp_scene* scene, uint8_t** wide);
