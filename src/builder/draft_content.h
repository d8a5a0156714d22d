// SPDX-License-Identifier: MIT
// Converts an unfinished scene to the input of the writer: the available results, and points for
// the rest.
#pragma once

#include "builder/writer_input.h"
#include "scene/scene.h"
#include "store/file/store.h"

/// The available results of a scene.
typedef struct stp_draft_state {
    const stp_scene* scene;      ///< finished, partitioned or not
    const stp_coded_mesh* coded; ///< one per mesh; without bytes: not coded yet. NULL: none is
    const stp_splats* sets;
    uint32_t set_count;
    const uint32_t* set_of_node; ///< STP_NONE: the node has no set yet. NULL: no node has
} stp_draft_state;

/// Makes a scene of the available results, with the same nodes and objects. Meshes that are not
/// coded yet become a few points. If drawing all triangles would take long, so do the meshes with
/// the smallest triangles. Content below a splat set does not count for this, because it is drawn
/// only from near. The caller adds shadings and parameters. @return STP_OK; STP_ERROR_LIMIT if the
/// scene is empty or has too many visible nodes to draw quickly, not logged;
/// STP_ERROR_OUT_OF_MEMORY (nothing to destroy)
STP_MUST_USE stp_result stp_draft_content_create(stp_context* context, const stp_draft_state* state,
                                                 stp_build_content* content);

// A quick preview of a mesh or point set: a few of its points, before anything else is made from
// it.

/// Makes `count` points on a mesh's triangles, spread by area, with face normals and the colours of
/// vertices and texture (if the scene has texels). Cut-out areas get none, so there may be fewer.
/// Deterministic. The arena owns the arrays. @return false if memory runs out
bool stp_preview_mesh(stp_arena* arena, const stp_scene* scene, uint32_t mesh, uint32_t count,
                      stp_store_point_set* points);

/// At most `count` of a point set's points with their attributes, spread over it; all of them if
/// there are no more.
bool stp_preview_points(stp_arena* arena, const stp_point_set* from, uint32_t count,
                        stp_store_point_set* points);
