// SPDX-License-Identifier: MIT
//
// Table of the methods that make splat sets, for the build and tools. `blue` samples the surface of
// each node; the others make their sets from those samples, which are evenly spread.
#pragma once

#include "base/io/hash.h"
#include "base/splats/splat_columns.h"
#include "lod/blue/blue.h"
#include "lod/psp/forest.h"
#include "lod/spt/point_tree.h"
#include "lod/stochastic/leaf_octree.h"

/// Options of all methods. Start from stp_method_options_default(); all zero is not the default.
typedef struct stp_method_options {
    stp_tree_desc tree;        ///< options of `spt`
    stp_psp_metric psp_metric; ///< which pairs `psp` merges; default STP_PSP_REGIONS
    stp_leaf_desc leaves;      ///< options of `stochastic`
} stp_method_options;

stp_method_options stp_method_options_default(void);

/// Input of methods other than `blue`. Arrays belong to the caller, and are only read.
typedef struct stp_method_source {
    const stp_splats* samples;   ///< the node's set of `blue`: evenly spread
    const stp_shading* shadings; ///< of the samples, for their growths; NULL: none has one
    /// Opaque triangles of the node whose level (base/splats/triangle_level.h) is above the
    /// coverage radius of all samples: 9 floats each, finite.
    const float* corners;
    uint32_t triangle_count;
    bool two_sided; ///< a cloud without normals: the signs of the samples' normals are a guess
} stp_method_source;

typedef struct stp_method {
    const char* name;
    const char* title;      ///< display name
    uint32_t id;            ///< STP_METHOD_*
    uint32_t columns;       ///< STP_SPLATS_*, of all its sets
    uint32_t split_columns; ///< further ones with STP_TREE_SPLIT
    bool finds_signs;       ///< it determines the outside of points without normals
    /// Adds to a content key everything besides samples that affects a set. NULL if `make` is NULL.
    stp_hash (*hash)(stp_hash key, const stp_method_options* options);
    /// Bytes of memory needed for making a set. NULL if `make` is NULL.
    uint64_t (*bytes)(uint64_t samples, uint64_t triangles);
    /// Makes a node's set. NULL: the samples are the set.
    /// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
    stp_result (*make)(stp_context* context, const stp_method_source* source,
                       const stp_method_options* options, stp_splats* splats);
    /// Makes a node's set from its candidates, without samples, if a file holds only sets of such
    /// methods. `desc->sets` are of the same method. NULL: it needs samples. @return as
    /// stp_blue_make
    stp_result (*make_alone)(const stp_scene* scene, uint32_t node,
                             const uint8_t* shading_of_material, const stp_blue_desc* desc,
                             const stp_method_options* options, stp_splats* splats,
                             stp_blue_report* report);
} stp_method;

enum { STP_METHOD_COUNT = 4 };

/// All methods; the first is `blue`.
extern const stp_method stp_methods[STP_METHOD_COUNT];

/// Columns of the sets that a method makes with these options.
uint32_t stp_method_columns(const stp_method* method, const stp_method_options* options);
/// Whether a file of these methods gets coarse ellipses: the first is `blue`, and none is `psp`,
/// whose ellipses are of all sets.
bool stp_methods_want_coarse(const stp_method* const* methods, uint32_t count);

/// Ellipses for few splats (docs/algorithms/progressive-sets.md, Coarse ellipses). The build makes
/// them beside `blue`; users do not choose them, so they are not in the table.
extern const stp_method stp_method_coarse;

/// Finds a method of the table by name or id. @return NULL if there is none
const stp_method* stp_method_by_name(const char* name);
const stp_method* stp_method_by_id(uint32_t id);
