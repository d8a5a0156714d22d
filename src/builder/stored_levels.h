// SPDX-License-Identifier: MIT
// The levels of a node in the work folder: one result, read in place.
//
//   head 64 | groups, 20 each | clusters, 12 each | levels, 64 each | coded meshes, each padded to 64
#pragma once

#include "base/io/hash.h"
#include "builder/stored_results.h"
#include "lod/levels/node_levels.h"
#include "store/clusters/clusters.h"

/// Levels of a node in the work folder. Pointers are valid until it is closed.
typedef struct stp_stored_levels {
    uint32_t level_count, group_count, cluster_count;
    bool from_outside;
    const unsigned char *groups, *clusters, *levels;
} stp_stored_levels;

/// One of its levels.
typedef struct stp_stored_level {
    uint8_t shading;
    double area; ///< of the coded triangles
    stp_coded_mesh coded;
} stp_stored_level;

/// Looks the levels of a node up. Drops a result that a writer would refuse, or that has a shading of
/// `shading_count` or above. Any thread.
bool stp_work_find_levels(stp_work* work, stp_hash key, uint32_t shading_count,
                          stp_stored_levels* levels);
/// Codes the meshes of a node's levels and stores them. Any thread. @return STP_OK, or as
/// stp_clusters_encode_ranges and stp_work_store
STP_MUST_USE stp_result stp_work_store_levels(stp_context* context, stp_work* work, stp_hash key,
                                              const stp_node_levels* levels);
/// The same with coded meshes, one per level; only the shadings and clusters of the levels are
/// read, without the ends of their triangles.
STP_MUST_USE stp_result stp_work_store_coded_levels(stp_context* context, stp_work* work,
                                                    stp_hash key, const stp_node_levels* levels,
                                                    const stp_coded_mesh* coded);

/// The key in a file of level `index` of a node whose levels have `key`.
stp_hash stp_level_key(stp_hash key, uint32_t index, uint8_t shading);
/// Takes the levels of a node from an earlier output into the work folder, if all are intact. One
/// thread at a time. @param shading_count  of the build
bool stp_previous_output_take_levels(stp_previous_output* previous, stp_hash key,
                                     uint32_t shading_count, stp_work* work);

stp_stored_level stp_stored_level_at(const stp_stored_levels* levels, uint32_t index);
/// Group `index`: 3 of the centre, radius, error.
void stp_stored_level_group(const stp_stored_levels* levels, uint32_t index, float group[5]);
/// Cluster `index`, counted through all levels: made_by, used_by (numbers of groups of the node, or
/// STP_LEVEL_NONE), one_sided.
void stp_stored_level_cluster(const stp_stored_levels* levels, uint32_t index, uint32_t cluster[3]);
