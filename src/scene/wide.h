// SPDX-License-Identifier: MIT
// Which nodes say nothing about place.
#pragma once

#include "scene/scene.h"

/// Finds the nodes that are dissolved into their parent: used once, by a parent that has more than them, as wide
/// as it, and not moving. An array of one byte a node (stp_free). @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_wide(const stp_scene* scene, uint8_t** wide);
