// SPDX-License-Identifier: MIT
// Counts the objects of a scene's input, part by part, as in Table 1 of the paper (Brandt 5.1).
#pragma once

#include "scene/scene.h"
#include "store/file/summary.h"

/// Counts a finished scene before it is partitioned, because partitioning splits meshes but each
/// must still count as one object. Parts are the children of the root; a single child without a
/// mesh is replaced by its own children, repeatedly. The scene owns the names. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged; nothing to destroy)
STP_MUST_USE stp_result stp_build_census(const stp_scene* scene, stp_store_census* census);
