// SPDX-License-Identifier: MIT
// Content of the file as the writer takes it: tables of the scene, encoded pictures, the accuracy
// of points, and object counts.
#pragma once

#include "builder/build_levels.h"
#include "builder/meshes.h"
#include "builder/method_sets.h"
#include "scene/scene.h"
#include "store/file/summary.h"
#include "store/writer/writer.h"

// Converts a finished scene to the input of the writer.

/// Input of the writer, and arrays that it needs in addition to the scene's.
typedef struct stp_build_content {
    stp_store_content content;
    stp_context* context;
    stp_arena arena;
} stp_build_content;

/// Converts the scene, which must outlive the content. `sets` are the splat sets. `set_of_node`
/// gives the set of each node, or STP_NONE (NULL: no node has one). `levels` may be NULL. The caller
/// adds shadings and parameters. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing to
/// destroy)
STP_MUST_USE stp_result stp_build_content_create(const stp_scene* scene, const stp_splats* sets,
                                                 uint32_t set_count, const uint32_t* set_of_node,
                                                 const stp_build_levels* levels,
                                                 stp_build_content* content);
/// Adds the coded meshes of the scene and of the levels, and their keys. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_content_add_meshes(stp_build_content* content,
                                                     const stp_scene* scene,
                                                     const stp_build_meshes* meshes,
                                                     const stp_build_levels* levels);
void stp_build_content_destroy(stp_build_content* content);

/// Encodes textures as PNG if they came in another format or import changed them, and if PNG is
/// smaller than the texels. Textures that came as PNG, JPEG or WebP stay as they are. All threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_build_encode_textures(stp_scene* scene);

// Accuracy of the points in sets (section 41 of docs/format.md).

/// Stores in the sets of all methods whether the signs of their normals are known, and the position
/// error of the points they hold, in scene units. `content` is made from the scene and these sets.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_note_certainty(const stp_scene* scene,
                                                 const stp_store_content* content,
                                                 stp_build_methods* methods);

/// Stores in the sets of a method that finds no signs, before all are made, whether those of their
/// normals are known.
/// @param set_of_node STP_NONE: the node has no set
/// @param context for memory. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_note_signs(stp_context* context, const stp_scene* scene,
                                             const uint32_t* set_of_node, stp_splats* sets);

// Counts the objects of a scene's input, part by part, as in Table 1 of the paper (Brandt 5.1).

/// Counts a finished scene before it is partitioned, because partitioning splits meshes but each
/// must still count as one object. Parts are the children of the root; a single child without a
/// mesh is replaced by its own children, repeatedly. The scene owns the names. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged; nothing to destroy)
STP_MUST_USE stp_result stp_build_census(const stp_scene* scene, stp_store_census* census);
