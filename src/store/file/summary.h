// SPDX-License-Identifier: MIT
//
// Statistics of a scene: of the whole and of each part (Brandt 2019, Table 1). The writer stores
// them, so that the first pages describe a file of any size.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

enum { STP_STORE_SCENE_PARTS = 64 }; ///< maximum number of parts, without the one for all others

/// Counts include all instances; `unique_...` counts stored items. Sums saturate. *objects*: uses
/// of an input object with a shape; unique: distinct shapes. *instances*: uses of meshes and point
/// sets, of which an object may have several. *lods*: nodes with splats; unique: splat sets.
/// Bytes are as stored. *surfels*: splats, under the name that files and reports have for them.
#define STP_STORE_FIGURES(X)                                                                       \
    X(objects)                                                                                     \
    X(unique_objects)                                                                              \
    X(instances)                                                                                   \
    X(nodes)                                                                                       \
    X(unique_nodes)                                                                                \
    X(lods)                                                                                        \
    X(unique_lods)                                                                                 \
    X(triangles)                                                                                   \
    X(unique_triangles)                                                                            \
    X(points)                                                                                      \
    X(unique_points)                                                                               \
    X(surfels)                                                                                     \
    X(unique_surfels)                                                                              \
    X(splat_bytes)                                                                                 \
    X(triangle_bytes)                                                                              \
    X(point_bytes)                                                                                 \
    X(texture_bytes)

typedef struct stp_store_figures {
#define X(name) uint64_t name;
    STP_STORE_FIGURES(X)
#undef X
} stp_store_figures;

/// A part of the scene: everything below one of the topmost objects, if there are several.
typedef struct stp_store_scene_part {
    const char* name; ///< may be NULL
    uint32_t object;  ///< its object; STP_STORE_NONE: the sum of several
    stp_store_figures figures;
} stp_store_scene_part;

typedef struct stp_store_summary {
    stp_store_figures figures;
    stp_boxd bounds; ///< bounding box of the whole scene; empty if the scene is
    uint32_t material_count, texture_count, mesh_count, point_set_count; ///< stored
    uint32_t part_count;
    stp_store_scene_part* parts;
} stp_store_summary;

/// A part of the input scene, before anything was split or grouped.
typedef struct stp_store_census_part {
    const char* name;        ///< may be NULL
    const uint32_t* members; ///< indices of its objects
    uint32_t member_count;
    uint64_t objects, unique_objects, instances;
} stp_store_census_part;

/// Object counts that the graph no longer has after the build split large meshes into pieces.
typedef struct stp_store_census {
    uint64_t objects, unique_objects, instances;
    uint32_t part_count;
    stp_store_census_part* parts;
    uint32_t* members; ///< owned: objects of all parts, part by part
} stp_store_census;

/// An object that becomes a part.
typedef struct stp_store_census_candidate {
    uint32_t object;
    uint64_t triangles;
    const char* name;
} stp_store_census_candidate;

/// Creates the parts of a census, without statistics: one per candidate, in order. Beyond
/// STP_STORE_SCENE_PARTS, only those with most triangles, and one named "others". @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged; nothing to destroy)
STP_MUST_USE stp_result stp_store_census_create(stp_context* context,
                                                const stp_store_census_candidate* candidates,
                                                size_t count, stp_store_census* census);
void stp_store_census_destroy(stp_context* context, stp_store_census* census);

typedef struct stp_store stp_store;
typedef struct stp_store_content stp_store_content;

/// Summarises content as the writer would store it, with its size in a file. The content owns the
/// names. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing to destroy)
STP_MUST_USE stp_result stp_store_summarise_content(stp_context* context,
                                                    const stp_store_content* content,
                                                    stp_store_summary* summary);
/// Summarises an open file from its tables, for files without a stored summary. Objects are then
/// the nodes with meshes or points of their own.
STP_MUST_USE stp_result stp_store_summarise(stp_store* store, stp_store_summary* summary);
void stp_store_summary_destroy(stp_context* context, stp_store_summary* summary);
