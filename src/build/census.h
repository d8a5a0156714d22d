// SPDX-License-Identifier: MIT
// Counts what a scene's input calls objects, part by part, as the paper's Table 1 does (Brandt 5.1).
#pragma once

#include "scene/scene.h"
#include "store/summary.h"

/// Of a finished scene, before it is partitioned: afterwards a mesh may have become many pieces, and must still be
/// one object. Parts are the children of the root, or of what is the only object below it, and so on, as long as
/// that has no mesh itself. Names belong to the scene.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; nothing is left to destroy)
STP_MUST_USE stp_result stp_build_census(const stp_scene* scene, stp_store_census* census);
