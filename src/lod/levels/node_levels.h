// SPDX-License-Identifier: MIT
//
// Levels of the triangles of a node and of all below it, ready to be stored: which clusters of the
// graph are worth it, as meshes of one shading each.
//
//   meshes, placed  ->  welded, with colours  ->  graph of levels  ->  meshes, coarse first
//
// Originals are not among them: below the least error that is stored, a view draws the meshes.
#pragma once

#include "capture/capture.h"
#include "lod/levels/level_graph.h"

enum {
    STP_LEVELS_LEAST = 1000,  ///< nodes with fewer triangles have no levels,
    STP_LEVELS_MOST = 400000, ///< nor those with more: those below may have some
};

/// Up to 128 triangles that are drawn or not.
typedef struct stp_node_level_cluster {
    uint32_t end;       ///< of its triangles in the mesh
    uint32_t made_by;   ///< group, as in stp_level_cluster; STP_LEVEL_NONE: nothing finer is stored
    uint32_t used_by;   ///< group; STP_LEVEL_NONE: nothing coarser is stored
    uint32_t one_sided; ///< its first triangles: only their front is seen from outside
} stp_node_level_cluster;

/// Clusters of similar errors and one shading.
typedef struct stp_node_level {
    uint8_t shading;
    uint32_t vertex_count, triangle_count, cluster_count;
    float* positions; ///< 3 per vertex
    uint16_t* colors; ///< 4 per vertex, linear, 65535 is 1; includes base colour and texture
    uint32_t* indices;
    stp_node_level_cluster* clusters;
    size_t vertex_capacity, color_capacity, triangle_capacity, cluster_capacity;
} stp_node_level;

typedef struct stp_node_levels {
    uint32_t level_count, group_count;
    stp_node_level* levels;  ///< coarse first
    stp_level_group* groups; ///< those that clusters name; numbers are floats
    bool from_outside;       ///< triangles that cannot be seen from outside are left out
    double step;             ///< grid of the positions, a power of two
    size_t level_capacity;
} stp_node_levels;

/// Makes the levels of a node's placed meshes (stp_scene_flatten); only those that levels replace
/// count. There are none if their triangles cannot be halved well below the node's size. May run
/// inside a parallel loop. @param shading_of_material  per material of the scene: those of one
/// shading share meshes @return STP_OK, or as stp_level_graph_make. Destroy in either case
STP_MUST_USE stp_result stp_node_levels_make(const stp_scene* scene, const stp_placed_part* parts,
                                             size_t part_count, const uint8_t* shading_of_material,
                                             const stp_capture_textures* textures,
                                             stp_node_levels* levels);
void stp_node_levels_destroy(stp_context* context, stp_node_levels* levels);

/// Whether levels stand for a part: a mesh of an opaque material.
bool stp_levels_replace(const stp_scene* scene, stp_part part);

/// Chooses the clusters of a graph that are stored, and makes meshes of them (level_meshes.c).
/// @param triangles  of the originals @param most  largest error of the finest stored mixture
STP_MUST_USE stp_result stp_level_meshes_make(const stp_scene* scene, const stp_level_graph* graph,
                                              const uint8_t* shading_of_material,
                                              uint32_t triangles, double most, double least_step,
                                              stp_node_levels* levels);
