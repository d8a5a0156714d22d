// SPDX-License-Identifier: MIT
// How the graph uses meshes and point sets.
#pragma once

#include "scene/scene.h"

enum { STP_USED_RESTING = 1, STP_USED_MOVING = 2 };

/// How the nodes use each mesh and each point set: arrays of one byte each (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged, nothing to free)
STP_MUST_USE stp_result stp_find_uses(const stp_scene* scene, const stp_node* nodes,
                                      size_t node_count, const stp_part* node_parts,
                                      uint8_t** mesh_uses, uint8_t** point_uses);

/// Frees the arrays of an unused mesh or point set; it keeps its index.
void stp_scene_release(stp_scene* scene, stp_part part);

/// Removes unused meshes and point sets; the others move up. Parts of objects that referred to them
/// get index STP_NONE. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_drop_unused(stp_scene* scene);
