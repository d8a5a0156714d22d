// SPDX-License-Identifier: MIT
// Splats of the nodes of a point tree, without their ranges of levels.
#pragma once

#include "lod/samples.h"

typedef struct stp_node_splat {
    uint16_t position[3]; ///< on the grid of the set
    int8_t normal[2];     ///< octahedral; of a sphere, that of its first leaf
    uint8_t color[3];
    uint8_t material; ///< shading of its first leaf
    uint8_t coverage; ///< a leaf has its sample's; other nodes the mean share of the leaves below
    uint8_t cluster;  ///< index of the normal's direction among 128 (Dachsbacher et al. 2003, 3.10)
    uint32_t shape;   ///< base/splats/splat_codes.h; without the flag for replacement by triangles
    float replaced;   ///< level up to which large triangles surround all leaves below
} stp_node_splat;

typedef struct stp_node_splats_desc {
    const uint8_t* materials; ///< 1 per sample
    const float* replaced;    ///< 1 per sample (stp_spt_find_replaced)
    stp_vec3 origin;          ///< origin of the grid to which positions are rounded
    float step;
} stp_node_splats_desc;

/// Makes the splat of each node, on all threads.
/// @param splats receives one per node of the tree, allocated with stp_alloc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_node_splats_make(stp_context* context, const stp_point_tree* tree,
                                             const stp_method_samples* samples,
                                             const stp_node_splats_desc* desc,
                                             stp_node_splat** splats);

// Splats that are replaced by large triangles (Dachsbacher et al. 2003, 3.8).

/// Finds for each sample the highest level at which drawn triangles surround it; 0 if there is
/// none. A triangle is drawn at levels below its own (base/splats/triangle_level.h). A sample next to
/// surface of smaller triangles keeps its splat, because the disk may cover some of that surface.
/// @param corners 9 floats per triangle, in the space of the samples; finite
/// @param levels receives one per sample
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_spt_find_replaced(stp_context* context,
                                              const stp_method_samples* samples, float step,
                                              const float* corners, uint32_t count, float* levels);
