// SPDX-License-Identifier: MIT
//
// Makes the splats of all nodes in a plan, bottom-up: one node per thread, then the upper ones on
// all threads. Each result is kept in the work folder immediately.
#pragma once

#include "builder/draft.h"
#include "builder/set_plan.h"
#include "builder/stored_results.h"
#include "lod/method.h"

typedef struct stp_build_nodes_desc {
    const stp_build_plan* plan;
    const stp_blue_desc* blue;
    const stp_method* method; ///< method of the sets, made without samples; NULL: `blue`
    const stp_method_options* options;
    const uint8_t* shading_of_material;
    uint32_t shading_count;
    bool from_triangles;   ///< captures triangles, not the children's results (Brandt 3.4)
    uint64_t memory_bytes; ///< for sets in progress; 0: no limit
    stp_work* work;
    stp_previous_output* previous; ///< NULL: none
    stp_build_draft* draft;        ///< NULL: none
} stp_build_nodes_desc;

/// Results, one per step of the plan. Their arrays are in the work folder.
typedef struct stp_build_nodes {
    stp_splats* sets;
    uint64_t candidates; ///< sum over steps; 0 for those from the previous output
    double capture_ms, order_ms, finish_ms; ///< sum over threads
    uint32_t made, found; ///< steps made now; steps whose result existed before the build
} stp_build_nodes;

/// Key of a step's set, derived from the step's key.
stp_hash stp_build_set_key(const stp_method* method, const stp_method_options* options,
                           stp_hash key);

/// @return STP_OK, or the failure of a stage (logged)
STP_MUST_USE stp_result stp_build_nodes_make(const stp_scene* scene,
                                             const stp_build_nodes_desc* desc,
                                             stp_build_nodes* nodes);
void stp_build_nodes_destroy(stp_context* context, stp_build_nodes* nodes);
