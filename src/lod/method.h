// SPDX-License-Identifier: MIT
//
// The methods by which sets of splats are made: one table, which build and tools go by. `blue` samples the surface of each
// node; the others make their sets of those samples, which are spread evenly.
#pragma once

#include "base/hash.h"
#include "lod/blue/blue.h"
#include "lod/spt/point_tree.h"
#include "lod/stochastic/leaf_octree.h"

#include <stipple/surfels.h>

/// Options of all methods. Start from stp_method_options_default(); all zero is not the default.
typedef struct stp_method_options {
    stp_tree_desc tree;   ///< of `spt`
    stp_leaf_desc leaves; ///< of `stochastic`
} stp_method_options;

stp_method_options stp_method_options_default(void);

/// What sets of other methods than `blue` are made of. Arrays are the caller's, and are only read.
typedef struct stp_method_source {
    const stp_splats* samples; ///< the node's set of `blue`: evenly spread
    /// Opaque triangles of the node whose level (base/triangle_level.h) is above what all samples cover to: 9 floats each,
    /// finite.
    const float* corners;
    uint32_t triangle_count;
    bool two_sided; ///< a cloud that has no normals: the signs of the samples' are a guess
} stp_method_source;

typedef struct stp_method {
    const char* name;
    const char* title; ///< for people
    uint32_t id;       ///< STP_METHOD_*
    uint32_t columns;  ///< STP_SPLATS_*, of its sets
    bool finds_signs;  ///< it finds out which side of points without normals is outside
    /// Adds to a content key whatever decides a set but its samples. NULL where `make` is.
    stp_hash (*hash)(stp_hash key, const stp_method_options* options);
    /// Memory that making takes.
    uint64_t (*bytes)(uint64_t samples, uint64_t triangles);
    /// Makes a node's set. NULL: its sets are the samples.
    /// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
    stp_result (*make)(stp_context* context, const stp_method_source* source,
                       const stp_method_options* options, stp_splats* splats);
    /// Makes a node's set of its candidates, without samples, where a file holds sets of such methods alone. `desc->sets` are
    /// of the same method. NULL: it needs samples. @return as stp_blue_make
    stp_result (*make_alone)(const stp_scene* scene, uint32_t node,
                             const uint8_t* shading_of_material, const stp_blue_desc* desc,
                             const stp_method_options* options, stp_splats* splats,
                             stp_blue_report* report);
} stp_method;

enum { STP_METHOD_COUNT = 4 };

/// All methods; the first is `blue`.
extern const stp_method stp_methods[STP_METHOD_COUNT];

/// By name or id. @return NULL where there is none
const stp_method* stp_method_by_name(const char* name);
const stp_method* stp_method_by_id(uint32_t id);
