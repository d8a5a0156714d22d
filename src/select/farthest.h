// SPDX-License-Identifier: MIT
//
// The points of a scene that lie farthest in given directions: what a camera must keep in the
// picture. The search opens only those boxes that reach farther than the farthest point so far, and
// reads the triangles and points of few parts.
#pragma once

#include "base/core/context.h"
#include "select/visibility.h"
#include "store/file/store.h"

#include <stipple/view.h>

/// A node or a part, at a place of the scene.
typedef struct stp_farthest_item {
    bool is_part;
    uint32_t kind, index;
    uint32_t state;       ///< for the graph: visibility
    stp_affine transform; ///< to scene space
    stp_boxd bounds;      ///< in its own space
} stp_farthest_item;

/// Callbacks that describe a scene. `user` is their first argument.
typedef struct stp_farthest_graph {
    const void* user;
    stp_farthest_item root; ///< a node
    /// Number of children and parts of a node.
    uint32_t (*count)(const void* user, const stp_farthest_item* node);
    /// Child or part `i` of a node. @return false if it is not visible
    bool (*get)(const void* user, const stp_farthest_item* node, uint32_t i,
                stp_farthest_item* child);
    /// The point of a part that is farthest in a direction; both are in the part's own space. @return
    /// false if the part's content is not available
    bool (*measure)(const void* user, const stp_farthest_item* part, stp_vec3d direction,
                    stp_vec3d* point);
} stp_farthest_graph;

/// Content of an open file.
typedef struct stp_farthest_store {
    stp_context* context;
    stp_store* store;
    const stp_visibility* visibility; ///< NULL: everything is visible
} stp_farthest_store;

/// The visible content of a file; `placed`: of this object only, or NULL. What a partial file lacks
/// counts as boxes. Points far from the rest of a cloud are left out (scene/strays.h). `content` must outlive the graph. @return false if the scene is empty
STP_MUST_USE bool stp_farthest_begin(const stp_farthest_store* content,
                                     const stp_placed_node* placed, stp_farthest_graph* graph);

/// The vertex of an array of positions, 3 floats each, that is farthest in a direction. `farthest`
/// is -HUGE_VAL, or the distance of `point`; both are kept if no vertex is farther.
void stp_farthest_vertex(const float* positions, size_t count, stp_vec3d direction,
                         double* farthest, stp_vec3d* point);

/// Finds, for each direction, a point in scene space that is as far as any content of the graph,
/// within 1/2000 of the diagonal of its bounds. Of a part that sections cut, what they leave of its
/// box counts. @return false if nothing is left, or memory runs out
STP_MUST_USE bool stp_farthest_find(stp_context* context, const stp_farthest_graph* graph,
                                    const stp_sections* sections, const stp_vec3d* directions,
                                    uint32_t count, stp_vec3d* points);
