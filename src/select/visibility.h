// SPDX-License-Identifier: MIT
//
// Visibility of objects: shown, hidden, or drawn as ghosts. In a shared graph an object is a node
// *at a place*: other instances of the node are not affected.
//
//   root --- street --- house --- door          hidden: the door of this house
//    mixed    mixed      mixed     hidden       splats of mixed nodes show the door: open them
//        `--- trees (unchanged: drawn by any level)
//
// The state is a tree of paths to the differences. Its size is proportional to what was set, and a
// frame visits only the visible part. It must not change during a selection that uses it
// (stp_quality.visibility).
#pragma once

#include "base/math/math.h"
#include "store/file/store.h"

typedef enum stp_show {
    STP_SHOW, ///< drawn
    /// Drawn in a share of its pixels (stp_draw_style.ghost): the background shows through
    STP_SHOW_GHOST,
    STP_SHOW_NOT,   ///< neither drawn nor picked
    STP_SHOW_MIXED, ///< a mix of these
} stp_show;

/// A node of the graph at a place of the scene: an object of the tree (store/outline/outline.h), or a
/// picked node.
typedef struct stp_placed_node {
    uint32_t node;
    stp_affine transform; ///< to scene space
} stp_placed_node;

typedef struct stp_visibility stp_visibility;

/// Everything is shown. Belongs to the store, which must outlive it.
STP_MUST_USE stp_result stp_visibility_create(stp_context* context, const stp_store* store,
                                              stp_visibility** visibility);
void stp_visibility_destroy(stp_visibility* visibility);

/// Resets the whole scene. To isolate an object, reset to STP_SHOW_NOT or STP_SHOW_GHOST, then set
/// the object to STP_SHOW.
void stp_visibility_reset(stp_visibility* visibility, stp_show show);

/// Sets an object and everything below it, overriding earlier settings there; not STP_SHOW_MIXED.
/// The graph need not reach its node: partitioning may have moved an object's content into other
/// nodes (docs/algorithms/scene.md), where it is found by its place. Coincident objects (the same
/// node at the same place) are all set.
/// @return STP_OK (also if the scene has no such object), STP_ERROR_LIMIT (the search would take
/// too long), STP_ERROR_OUT_OF_MEMORY; logged. After a failure, the change may be partly applied.
STP_MUST_USE stp_result stp_visibility_set(stp_visibility* visibility,
                                           const stp_placed_node* placed, stp_show show);

/// Bounding box, in scene space, of everything drawn, including ghosts; of the whole scene if
/// `visibility` is NULL. Empty if nothing is drawn. Ignores sections.
stp_boxd stp_visible_bounds(const stp_store* store, const stp_visibility* visibility);

/// How far stored triangles and splats may lie outside the bounds of their nodes, in scene units:
/// their positions are rounded. 0 if memory runs out. Takes time proportional to the nodes.
double stp_bounds_rounding(stp_context* context, const stp_store* store);

/// Version number: differs after every change.
uint64_t stp_visibility_version(const stp_visibility* visibility);

// For graph traversals: the state of a node at a place, starting with stp_visibility_root. Values
// up to STP_SHOW_NOT apply to everything below; larger values are mixed.
uint32_t stp_visibility_root(const stp_visibility* visibility);
/// State of the target of an edge (`slot` below the node's edge_count), or of a part (slot -
/// edge_count), of a mixed node.
uint32_t stp_visibility_below(const stp_visibility* visibility, uint32_t state, uint32_t slot);

static inline stp_show stp_show_of(uint32_t state)
{
    return state < STP_SHOW_MIXED ? (stp_show)state : STP_SHOW_MIXED;
}
