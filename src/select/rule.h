// SPDX-License-Identifier: MIT
//
// Rules of the methods: which part of a set a view draws, and the depth beyond which the set
// suffices. The rest of a selection (visibility, occlusion, residency) is the same for all methods.
#pragma once

#include "select/select_internal.h"

typedef struct stp_select_rule {
    /// Decides by size how to use a node's set. The eye is outside the node's box, unless `cloud`:
    /// the node is never opened. On entry `use` holds the set, opens the node, and has
    /// per_depth > 0.
    void (*choose)(const stp_selection* s, const stp_select_entry* at,
                   const stp_box_visibility* sight, bool cloud, stp_set_use* use);
    /// Uses `count` splats at any depth: a prefix, a state, or a share of each leaf.
    void (*choose_count)(stp_set_use* use, uint32_t count);
    /// Adapts `use` to a set with only its first `here` splats loaded, or to a node that cannot be
    /// opened yet. The splats are seen at depth `nearest` and beyond.
    void (*limit)(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use);
    /// Appends the item of a set, with its runs.
    stp_result (*add)(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_box_visibility* sight);
} stp_select_rule;

extern const stp_select_rule stp_select_rule_blue, stp_select_rule_levels, stp_select_rule_splits,
    stp_select_rule_cues;

/// Returns the rule of a method (STP_METHOD_*); unknown methods use the rule of `blue`.
const stp_select_rule* stp_select_rule_of(uint32_t id);

// Large triangles drawn beside the splats of a node's set (Dachsbacher et al. 2003, 3.8): those of
// its own meshes and of all meshes below, if these are few (rule_triangles.c).
/// Whether they are drawn: they replace splats of the set, and all of them are resident.
stp_result stp_select_choose_triangles(stp_selection* s, const stp_select_entry* at,
                                       const stp_set_use* use, const stp_box_visibility* sight,
                                       bool* uses);
/// Appends their items; the set's item is the last one so far.
stp_result stp_select_add_triangles(stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use, const stp_box_visibility* sight);

/// For a set whose splats have levels, finds the nearest depth at which it is drawn: the node's
/// nearest depth if the set suffices there, else the depth beyond which it does. Sets the switch
/// depth. @return false: the set is not drawn
bool stp_select_find_nearest(const stp_selection* s, const stp_select_entry* at,
                             const stp_box_visibility* sight, bool cloud, stp_set_use* use,
                             double* nearest);
/// Initial use of a set: draws nothing of it, and opens the node.
stp_set_use stp_select_begin_use(const stp_selection* s, const stp_select_rule* rule, uint32_t set);
/// Switches to the coarse method's set if only a small share of this set is used and the other one
/// is resident.
void stp_select_choose_coarse(stp_selection* s, const stp_select_entry* at,
                              const stp_box_visibility* sight, stp_set_use* use);

/// The same for `count` splats. Keeps `use` if the coarse set has no state of that count.
stp_result stp_select_count_coarse(stp_selection* s, const stp_select_entry* at,
                                   const stp_box_visibility* sight, uint32_t count,
                                   stp_set_use* use);

/// Decides how to use the set of a node, which has one, when splats are drawn by size.
stp_set_use stp_select_choose_use(const stp_selection* s, const stp_select_entry* at,
                                  const stp_box_visibility* sight);
