// SPDX-License-Identifier: MIT
//
// Makes the sets of all requested methods, and lists the large triangles that some methods draw
// beside splats.
#pragma once

#include "builder/nodes.h"
#include "builder/set_plan.h"
#include "builder/stored_results.h"
#include "lod/method.h"
#include "scene/scene.h"

// Sets of `blue` exist already; the others are derived from them, one node per thread. Each result
// is kept in the work folder immediately.

typedef struct stp_build_methods_desc {
    const stp_build_plan* plan;
    const stp_splats* samples; ///< sets of `blue`, one per step of the plan
    /// NULL, or the only method, which needs no samples: `samples` are its sets.
    const stp_method* alone;
    const stp_method* const* methods;
    uint32_t method_count; ///< at least 1; no duplicates
    /// NULL, or a further method, which comes last and has sets for the uppermost nodes only.
    const stp_method* coarse;
    const stp_method_options* options;
    uint32_t shading_count;
    const stp_shading* shadings;     ///< of the samples
    const stp_growth_table* growths; ///< of these shadings; NULL: none
    uint64_t memory_bytes;           ///< for sets in progress; 0: no limit
    stp_work* work;
    stp_previous_output* previous; ///< NULL: none
} stp_build_methods_desc;

/// All sets, grouped by method, one per step of the plan, of the coarse method one per uppermost
/// step. Columns are in the work folder.
typedef struct stp_build_methods {
    stp_splats* sets;
    stp_hash* keys;
    uint32_t set_count;
    stp_store_method* methods; ///< as in the file's directory
    uint32_t method_count;
    uint32_t* sets_of_nodes; ///< for methods after the first: by method, then by node
    uint32_t made, found;    ///< not counting samples
} stp_build_methods;

/// @return STP_OK, or the failure of a stage (logged)
STP_MUST_USE stp_result stp_build_methods_make(const stp_scene* scene,
                                               const stp_build_methods_desc* desc,
                                               stp_build_methods* made);
void stp_build_methods_destroy(stp_context* context, stp_build_methods* made);

// The large triangles of a node (Dachsbacher et al. 2003, 3.8).

typedef struct stp_node_triangles {
    uint32_t count;
    float* corners; ///< 9 floats each, in the node's space
} stp_node_triangles;

/// Counts the opaque triangles whose level (base/splats/triangle_level.h) is above `level`, in the
/// node and everything below it that does not move. Returns 0 if more than STP_LARGE_USES parts and
/// nodes are below it.
uint32_t stp_count_node_triangles(const stp_scene* scene, uint32_t node, double level);

/// Lists these triangles.
/// @param count from stp_count_node_triangles.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Free with stp_node_triangles_destroy
STP_MUST_USE stp_result stp_take_node_triangles(const stp_scene* scene, uint32_t node, double level,
                                                uint32_t count, stp_node_triangles* triangles);
void stp_node_triangles_destroy(stp_context* context, stp_node_triangles* triangles);
