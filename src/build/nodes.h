// SPDX-License-Identifier: MIT
//
// Makes the surfels of all nodes of a plan: bottom-up, one node a thread, each result kept in the work directory
// as soon as it is there.
#pragma once

#include "build/draft.h"
#include "build/plan.h"
#include "build/previous_output.h"
#include "lod/method.h"

typedef struct stp_build_nodes_desc {
    const stp_build_plan* plan;
    const stp_blue_desc* blue;
    const stp_method* method; ///< whose sets they are, made without samples; NULL: `blue`
    const stp_method_options* options;
    const uint8_t* shading_of_material;
    uint32_t shading_count;
    bool from_triangles;   ///< top-down: children's results are not used (Brandt 3.4)
    uint64_t memory_bytes; ///< for what is in the making; 0: no limit
    stp_work* work;
    stp_previous_output* former; ///< NULL: none
    stp_build_draft* draft;      ///< NULL: none
} stp_build_nodes_desc;

/// Results, one a step of the plan. Their arrays lie in the work directory or the former output.
typedef struct stp_build_nodes {
    stp_splats* sets;
    uint64_t candidates;                    ///< over all steps that were made now
    double capture_ms, order_ms, finish_ms; ///< of threads' time
    uint32_t made, found; ///< steps made now; steps whose result was there before the build began
} stp_build_nodes;

/// Under which key a step's set is kept, by the key of the step.
stp_hash stp_build_set_key(const stp_method* method, const stp_method_options* options,
                           stp_hash key);

/// @return STP_OK, or what the stages return (logged)
STP_MUST_USE stp_result stp_build_nodes_make(const stp_scene* scene,
                                             const stp_build_nodes_desc* desc,
                                             stp_build_nodes* nodes);
void stp_build_nodes_destroy(stp_context* context, stp_build_nodes* nodes);
