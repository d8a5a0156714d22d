// SPDX-License-Identifier: MIT
// Which nodes say nothing about place.
#pragma once

#include "scene/scene.h"

enum { STP_DISSOLVED = 1, STP_DISSOLVED_IN_ROOT = 2 };

/// Finds the nodes that are dissolved into their parent: used once, by a parent that has more than them, as wide
/// as it, and not moving. And those into the root that only stand between it and its content, turning or scaling
/// a whole input: else the whole would be approximated twice. An array of one byte a node (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_wide(const stp_scene* scene, uint8_t** wide);
