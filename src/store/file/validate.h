// SPDX-License-Identifier: MIT
//
// The invariants of a scene in a file. The reader checks decoded data, the writer its input: it
// never writes what cannot be read.
#pragma once

#include "store/file/content.h"

/// Context of a validation: the file, and the result of a failed one.
typedef struct stp_store_validator {
    stp_context* context;
    const char* path;
    stp_result failure;
    bool warns; ///< bulk data: report faults as warnings, because no call fails
} stp_store_validator;

/// The graph, its parts, materials and shadings; not the objects.
STP_MUST_USE stp_result stp_store_validate_graph(const stp_store_validator* validator,
                                                 const stp_store_directory* directory);
STP_MUST_USE stp_result stp_store_validate_objects(const stp_store_validator* validator,
                                                   const stp_store_directory* directory);

// Descriptions of bulk data, without its values.
/// Checks the material of a mesh or point set (`what`).
STP_MUST_USE stp_result stp_store_validate_material(const stp_store_validator* validator,
                                                    const char* what, uint32_t index,
                                                    uint32_t material, uint32_t material_count);
STP_MUST_USE stp_result stp_store_validate_texture(const stp_store_validator* validator,
                                                   uint32_t index,
                                                   const stp_store_texture* texture);
STP_MUST_USE stp_result stp_store_validate_splat_set(const stp_store_validator* validator,
                                                     uint32_t index, const stp_splats* splats);
/// What is wrong with a set, apart from its columns, or NULL.
const char* stp_store_splat_set_fault(const stp_splats* splats);

/// The leaves of a set, if it has any.
STP_MUST_USE stp_result stp_store_validate_leaves(const stp_store_validator* validator,
                                                  uint32_t index, const stp_splats* splats);

/// The levels: their nodes, meshes, clusters and groups. Requires a valid graph.
STP_MUST_USE stp_result stp_store_validate_levels(const stp_store_validator* validator,
                                                  const stp_store_content* content);
/// What is wrong with the clusters of a level's mesh, or NULL. `levels` has one for each cluster.
const char* stp_store_level_fault(const stp_store_level_cluster* levels,
                                  const stp_clusters* clusters);

// The bulk data.
STP_MUST_USE stp_result stp_store_validate_mesh_data(const stp_store_validator* validator,
                                                     uint32_t index, const stp_store_mesh* mesh);
STP_MUST_USE stp_result stp_store_validate_point_data(const stp_store_validator* validator,
                                                      uint32_t index,
                                                      const stp_store_point_set* points);
/// Whether a set of splats can hold a point set.
STP_MUST_USE stp_result stp_store_validate_held_points(const stp_store_validator* validator,
                                                       uint32_t index,
                                                       const stp_store_point_set* points,
                                                       const stp_splats* set);
/// The columns to be checked for some splats of a set.
typedef struct stp_store_splat_data {
    uint64_t count;
    const uint8_t* materials;
    const uint32_t *shapes, *ranges; ///< NULL: the set has none
} stp_store_splat_data;

STP_MUST_USE stp_result stp_store_validate_splat_data(const stp_store_validator* validator,
                                                      uint32_t index,
                                                      const stp_store_splat_data* data,
                                                      uint32_t shading_count);
