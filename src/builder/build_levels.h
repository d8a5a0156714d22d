// SPDX-License-Identifier: MIT
//
// Levels of the triangles of all nodes, as the writer takes them. Each node's levels are kept in
// the work folder as soon as they are made, or found in an earlier output.
#pragma once

#include "builder/shadings.h"
#include "builder/stored_results.h"
#include "lod/levels/node_levels.h"
#include "store/file/store.h"

/// Numbers of nodes, meshes and materials are those of the file: levels are its last meshes, and
/// have the last materials, one per shading. The arrays are owned; coded bytes are in the work
/// folder.
typedef struct stp_build_levels {
    uint32_t level_count, cluster_count, group_count, material_count;
    stp_store_level* levels;
    stp_store_level_cluster* clusters;
    stp_store_level_group* groups;
    stp_store_mesh* meshes; ///< one per level: counts, material, area
    stp_coded_mesh* coded;  ///< one per level
    stp_hash* keys;         ///< one per level
    uint32_t made, found;   ///< nodes whose levels were made now, or existed before the build
    stp_store_material* materials;
} stp_build_levels;

typedef struct stp_build_levels_desc {
    const uint8_t* shading_of_material;
    const stp_shading* shadings;
    uint32_t shading_count;
    uint64_t memory_bytes; ///< for nodes in progress; 0: no limit
    stp_work* work;
    stp_previous_output* previous; ///< NULL: none
} stp_build_levels_desc;

/// @return STP_OK, or the failure of a stage (logged; nothing to destroy)
STP_MUST_USE stp_result stp_build_levels_make(const stp_scene* scene,
                                              const stp_build_levels_desc* desc,
                                              stp_build_levels* levels);
void stp_build_levels_destroy(stp_context* context, stp_build_levels* levels);
