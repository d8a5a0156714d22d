// SPDX-License-Identifier: MIT
//
// Which nodes of a scene get surfels, and in which order they are made.
#pragma once

#include "base/hash.h"
#include "build/shadings.h"
#include "lod/blue/blue.h"

typedef struct stp_build_step {
    uint32_t node;
    uint32_t height; ///< steps of lower heights do not need this one's result
    uint32_t
        needs; ///< so many steps, the first ones, must be done before: results below are among them
    uint32_t surfel_count; ///< most surfels, as stp_blue_desc has it
    double cost;           ///< of making it, in no unit: for shares of the whole
    uint64_t bytes;        ///< memory that making it takes, about
    stp_hash key;          ///< of everything that decides the result
} stp_build_step;

typedef struct stp_build_plan {
    stp_build_step* steps; ///< children before parents: by height, the costly first
    uint32_t step_count;
    uint32_t
        shared_count; ///< of these are run a thread each; the rest, too few at a time, with all threads each
    uint32_t* step_of; ///< for each node its step, STP_NONE where it gets no surfels
    double cost;       ///< of all steps
} stp_build_plan;

#define STP_BUILD_NO_SURFELS UINT64_MAX

typedef struct stp_build_plan_desc {
    const stp_blue_desc* blue;
    const uint8_t* shading_of_material;
    const stp_shading* shadings;
    uint64_t
        threshold; ///< a node gets surfels above so many triangles; STP_BUILD_NO_SURFELS: never
    bool from_triangles; ///< results of children are not used
} stp_build_plan_desc;

/// A node above the threshold gets surfels, with two exceptions. What counts of it is what rests: nodes that move
/// below it are in no set but their own, which stands for them wherever they are.
///
/// Where the nearest set above serves as well: a set of fewer than the most surfels has one for two triangles, as
/// its parent's has, so it pays only where it is finer (its parts are smaller than what is around them), or a small
/// piece of a large whole.
///
/// Where prefixes of the sets below serve as well: together they draw the node with as many splats as its own set
/// would. It pays where they are too many to be looked at one by one, or hold much that cannot be seen.
///
/// A node with points of its own always gets all of them as surfels: points have no size but theirs.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_plan_make(const stp_scene* scene, const stp_build_plan_desc* desc,
                                            stp_build_plan* plan);
void stp_build_plan_destroy(stp_context* context, stp_build_plan* plan);
