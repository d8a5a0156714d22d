// SPDX-License-Identifier: MIT
//
// Chooses the nodes of a scene that get splats, and the order in which they are made.
#pragma once

#include "base/io/hash.h"
#include "builder/shadings.h"
#include "lod/blue/blue.h"

typedef struct stp_build_step {
    uint32_t node;
    uint32_t height; ///< steps of lower heights do not depend on this one's result
    /// Number of leading steps that must be done first; they include all results below.
    uint32_t needs;
    uint32_t splat_count; ///< as in stp_blue_desc
    double cost;          ///< relative cost, for progress
    uint64_t bytes;       ///< estimated peak memory
    stp_hash key;         ///< hash of everything that determines the result
} stp_build_step;

typedef struct stp_build_plan {
    stp_build_step* steps; ///< children before parents: by height, then by cost, highest first
    uint32_t step_count;
    /// These steps run one per thread; the rest run one by one on all threads.
    uint32_t shared_count;
    uint32_t* step_of; ///< by node: its step, or STP_NONE without splats
    double cost;       ///< sum over all steps
} stp_build_plan;

#define STP_BUILD_NO_SPLATS UINT64_MAX

typedef struct stp_build_plan_desc {
    const stp_blue_desc* blue; ///< its splat_count is not used
    stp_splat_rule rule;       ///< splats of each node
    const uint8_t* shading_of_material;
    const stp_shading* shadings;
    uint64_t threshold;  ///< nodes with more triangles get splats; STP_BUILD_NO_SPLATS: never
    bool from_triangles; ///< results of children are not used
} stp_build_plan_desc;

/// A node above the threshold gets splats, with two exceptions. Only resting content counts:
/// moving nodes below it have their own sets, which represent them wherever they are.
///
/// First exception: the nearest set above serves as well. A set of fewer than the maximum splats
/// has one splat for so many triangles, and so has its parent's. So it pays only if it is finer
/// (its parts are smaller than their surroundings), or a small part of a large whole, or repeated:
/// then one set replaces those of the groups of copies.
///
/// Second exception: prefixes of the sets below serve as well. Together they draw the node with as
/// many splats as its own set. Its own set pays only if they are too many to examine one by one, or
/// contain many hidden surfaces.
///
/// A node with points of its own gets splats at any threshold except STP_BUILD_NO_SPLATS, because
/// only splats give points a size.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_plan_make(const stp_scene* scene, const stp_build_plan_desc* desc,
                                            stp_build_plan* plan);
void stp_build_plan_destroy(stp_context* context, stp_build_plan* plan);
