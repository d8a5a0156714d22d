// SPDX-License-Identifier: MIT
//
// What a scene holds, in figures: of the whole and of each of its parts (Brandt 2019, Table 1). The writer
// stores them, so that a file of any size says what it is from its first pages.
#pragma once

#include "base/context.h"
#include "base/math.h"

enum { STP_STORE_SCENE_PARTS = 64 }; ///< most parts, beside one that stands for all others

/// Counts with all instances, and `unique_...` of what is stored. Sums stop at the largest number.
/// *objects*: uses of what the input calls one thing with a shape; unique: distinct shapes. *instances*: uses of
/// meshes and point sets, of which an object may have several. *lods*: nodes with surfels; unique: surfel sets.
/// Bytes are those stored.
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

/// A part of the scene: what hangs below one of the uppermost objects that are several.
typedef struct stp_store_scene_part {
    const char* name; ///< may be NULL
    uint32_t object;  ///< which object it is; STP_STORE_NONE: several, summed
    stp_store_figures figures;
} stp_store_scene_part;

typedef struct stp_store_summary {
    stp_store_figures figures;
    stp_boxd bounds; ///< of the whole scene; empty where there is nothing
    uint32_t material_count, texture_count, mesh_count, point_set_count; ///< stored
    uint32_t part_count;
    stp_store_scene_part* parts;
} stp_store_summary;

/// A part of a scene as its input has it, before anything was cut or grouped.
typedef struct stp_store_census_part {
    const char* name;        ///< may be NULL
    const uint32_t* members; ///< the objects that it is, by index
    uint32_t member_count;
    uint64_t objects, unique_objects, instances;
} stp_store_census_part;

/// What the graph in a file no longer tells, where the build cut large meshes into pieces.
typedef struct stp_store_census {
    uint64_t objects, unique_objects, instances;
    uint32_t part_count;
    stp_store_census_part* parts;
    uint32_t* members; ///< of all parts
} stp_store_census;

/// An object that is to become a part.
typedef struct stp_store_census_candidate {
    uint32_t object;
    uint64_t triangles;
    const char* name;
} stp_store_census_candidate;

/// Makes the parts of a census, without their figures: one for each candidate in their order; of more than
/// STP_STORE_SCENE_PARTS, those with most triangles, and one named "others".
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; nothing is left to destroy)
STP_MUST_USE stp_result stp_store_census_create(stp_context* context,
                                                const stp_store_census_candidate* candidates,
                                                size_t count, stp_store_census* census);
void stp_store_census_destroy(stp_context* context, stp_store_census* census);

typedef struct stp_store stp_store;
typedef struct stp_store_content stp_store_content;

/// Of what a writer would be given, with the bytes it would take in a file. Names belong to the content.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing is left to destroy)
STP_MUST_USE stp_result stp_store_summarise_content(stp_context* context,
                                                    const stp_store_content* content,
                                                    stp_store_summary* summary);
/// Of a whole open file, from its tables alone: for files that store no summary. Objects are then the nodes
/// with meshes or points of their own.
STP_MUST_USE stp_result stp_store_summarise(stp_store* store, stp_store_summary* summary);
void stp_store_summary_destroy(stp_context* context, stp_store_summary* summary);
