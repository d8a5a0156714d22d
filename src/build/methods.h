// SPDX-License-Identifier: MIT
//
// The sets of all methods that were asked for: those of `blue` are there, the others are made of them, one node a thread,
// each result kept in the work directory as soon as it is there.
#pragma once

#include "build/nodes.h"
#include "build/plan.h"
#include "build/previous_output.h"
#include "lod/method.h"

typedef struct stp_build_methods_desc {
    const stp_build_plan* plan;
    const stp_splats* samples; ///< sets of `blue`, one a step of the plan
    /// NULL, or the only method, whose sets were made without samples: `samples` are these.
    const stp_method* alone;
    const stp_method* const* methods;
    uint32_t method_count; ///< at least 1; each method once
    const stp_method_options* options;
    uint32_t shading_count;
    uint64_t memory_bytes; ///< for what is in the making; 0: no limit
    stp_work* work;
    stp_previous_output* former; ///< NULL: none
} stp_build_methods_desc;

/// All sets, those of a method together, one a step of the plan. Columns lie in the work directory or the former output.
typedef struct stp_build_methods {
    stp_splats* sets;
    stp_hash* keys;
    uint32_t set_count;
    stp_store_method* methods; ///< as the file's directory has them
    uint32_t method_count;
    uint32_t* sets_of_nodes; ///< of methods after the first: by method, then by node
    uint32_t made, found;    ///< sets that are not samples
} stp_build_methods;

/// @return STP_OK, or what the stages return (logged)
STP_MUST_USE stp_result stp_build_methods_make(const stp_scene* scene,
                                               const stp_build_methods_desc* desc,
                                               stp_build_methods* made);
void stp_build_methods_destroy(stp_context* context, stp_build_methods* made);
