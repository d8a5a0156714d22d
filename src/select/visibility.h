// SPDX-License-Identifier: MIT
//
// What of a scene is shown, hidden, or drawn as a ghost. In a shared graph a thing is a node *at a place*: what else uses the
// node is not touched.
//
//   root --- street --- house --- door          hidden: the door of this house
//    mixed    mixed      mixed     hidden       surfels of mixed nodes show the door: they are opened instead
//        `--- trees (all as before: drawn by any level)
//
// So what is kept is a tree of the paths to what differs: as large as what was set, and a frame looks at no more of it
// than it sees. Whoever selects with it (stp_quality.visibility) must not change it meanwhile.
#pragma once

#include "base/math.h"
#include "store/store.h"

typedef enum stp_show {
    STP_SHOW, ///< drawn
    STP_SHOW_GHOST, ///< drawn in some of its pixels only (stp_draw_style.ghost): what is behind shows through
    STP_SHOW_NOT,   ///< neither drawn nor picked
    STP_SHOW_MIXED, ///< not all of it is one of these
} stp_show;

/// A node of the graph at a place of the scene: an object of the tree (store/outline.h), or what was picked.
typedef struct stp_placed_node {
    uint32_t node;
    stp_affine transform; ///< to scene space
} stp_placed_node;

typedef struct stp_visibility stp_visibility;

/// Everything is shown. Belongs to the store, which must outlive it.
STP_MUST_USE stp_result stp_visibility_create(stp_context* context, const stp_store* store,
                                              stp_visibility** visibility);
/// The same again, for a thread that draws while this one is changed.
STP_MUST_USE stp_result stp_visibility_copy(stp_context* context, const stp_visibility* from,
                                            stp_visibility** copy);
void stp_visibility_destroy(stp_visibility* visibility);

/// The whole scene. Isolated is what was set to STP_SHOW after all was reset to STP_SHOW_NOT or STP_SHOW_GHOST.
void stp_visibility_reset(stp_visibility* visibility, stp_show show);

/// A thing with all that is below it, whatever was set of that before; not STP_SHOW_MIXED. It need not be a node that the
/// graph reaches: partition may have spread an object's content over others' nodes (docs/design.md), and what stands at its
/// place is found there. Of things that coincide (the same node at the same place), all are set.
/// @return STP_OK (also where there is no such thing in the scene), STP_ERROR_LIMIT (it would take too long to find),
/// STP_ERROR_OUT_OF_MEMORY; logged. After a failure, what is shown is between before and what was asked for.
STP_MUST_USE stp_result stp_visibility_set(stp_visibility* visibility, const stp_placed_node* thing,
                                           stp_show show);

/// The box, in scene space, of all that is drawn, ghosts too; of the whole scene where `visibility` is NULL. Empty where
/// nothing is drawn. Sections do not count.
stp_boxd stp_visible_bounds(const stp_store* store, const stp_visibility* visibility);

/// A number that changes with every change: what was made with another one is old.
uint64_t stp_visibility_version(const stp_visibility* visibility);

// For those who walk the graph: a state of a node at a place, beginning with stp_visibility_root. Up to
// STP_SHOW_NOT it holds for all that is below; others are mixed.
uint32_t stp_visibility_root(const stp_visibility* visibility);
/// Of what an edge (`slot` below the node's edge_count) or a part (slot - edge_count) of a mixed node leads to.
uint32_t stp_visibility_below(const stp_visibility* visibility, uint32_t state, uint32_t slot);

static inline stp_show stp_show_of(uint32_t state)
{
    return state < STP_SHOW_MIXED ? (stp_show)state : STP_SHOW_MIXED;
}
