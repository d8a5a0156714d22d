// SPDX-License-Identifier: MIT
// Splats of the nodes of a point tree, without their ranges of levels.
#pragma once

#include "lod/samples.h"

typedef struct stp_node_splat {
    uint16_t position[3]; ///< on the grid of the set
    int8_t normal[2];     ///< octahedral; of a sphere its first leaf's
    uint8_t color[3];
    uint8_t material; ///< of its first leaf
    uint8_t coverage; ///< of a leaf its sample's, otherwise the mean share of the leaves below
    uint8_t cluster;  ///< of 128 directions, the one of its normal (Dachsbacher et al. 2003, 3.10)
    uint32_t shape;   ///< base/splat_codes.h; not whether triangles replace it
    float replaced;   ///< the level up to which large triangles lie all around the leaves below
} stp_node_splat;

typedef struct stp_node_splats_desc {
    const uint8_t* materials; ///< 1 a sample
    const float* replaced;    ///< 1 a sample (replaced.h)
    stp_vec3 origin;          ///< of the grid that positions are rounded to
    float step;
} stp_node_splats_desc;

/// Makes the splat of each node, on all threads.
/// @param splats one for each node of the tree; from stp_alloc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_node_splats_make(stp_context* context, const stp_point_tree* tree,
                                             const stp_method_samples* samples,
                                             const stp_node_splats_desc* desc,
                                             stp_node_splat** splats);
