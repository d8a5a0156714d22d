// SPDX-License-Identifier: MIT
// The large triangles of a node, for methods that draw them beside splats (Dachsbacher et al. 2003,
// 3.8).
#pragma once

#include "scene/scene.h"

typedef struct stp_node_triangles {
    uint32_t count;
    float* corners; ///< 9 floats each, in the node's space
} stp_node_triangles;

/// Counts the opaque triangles whose level (base/splats/triangle_level.h) is above `level`, in the node
/// and everything below it that does not move. Returns 0 if more than STP_LARGE_USES parts and
/// nodes are below it.
uint32_t stp_count_node_triangles(const stp_scene* scene, uint32_t node, double level);

/// Lists these triangles.
/// @param count from stp_count_node_triangles.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Free with stp_node_triangles_destroy
STP_MUST_USE stp_result stp_take_node_triangles(const stp_scene* scene, uint32_t node, double level,
                                                uint32_t count, stp_node_triangles* triangles);
void stp_node_triangles_destroy(stp_context* context, stp_node_triangles* triangles);
