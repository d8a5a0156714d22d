// SPDX-License-Identifier: MIT
//
// The rules of methods: what a view draws of a set, and from what depth on it suffices. Everything else of a selection
// (what is seen, hidden, resident) is the same for all.
#pragma once

#include "select/select_internal.h"

typedef struct stp_select_rule {
    /// Decides how to use a node's set by size. Called if the eye is outside the node's box. On
    /// entry `use` holds the set, opens the node, and has per_depth > 0.
    void (*use)(const stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                bool cloud, stp_set_use* use);
    /// Uses `count` splats wherever they are: the first, or as many as `use` says otherwise.
    void (*use_count)(stp_set_use* use, uint32_t count);
    /// Adapts `use` to a set of which only the first `here` splats are loaded, or to a node that cannot be opened yet. The
    /// splats are seen at depth `nearest` and beyond.
    void (*limit)(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use);
    /// Appends the item of a set, with its runs.
    stp_result (*add)(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_sight* sight);
} stp_select_rule;

extern const stp_select_rule stp_select_rule_blue, stp_select_rule_levels, stp_select_rule_splits,
    stp_select_rule_cues;

/// By the id of a method (STP_METHOD_*); that of `blue` for others.
const stp_select_rule* stp_select_rule_of(uint32_t id);

// Large triangles beside the splats of a node that is drawn by its set (Dachsbacher et al. 2003, 3.8): those of its own meshes
// and of all below it, where these are few (rule_triangles.c).
/// Whether they are drawn: the set has splats that they replace, and all are here.
stp_result stp_select_use_triangles(stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use, const stp_sight* sight, bool* uses);
/// Appends their items; the set's is the last one so far.
stp_result stp_select_add_triangles(stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use, const stp_sight* sight);

/// Finds the nearest depth at which a set is drawn whose splats have levels: that of the node where the set suffices, else the
/// depth from which it does. Sets the switch depth. @return false: the set is not drawn
bool stp_select_find_nearest(const stp_selection* s, const stp_select_entry* at,
                             const stp_sight* sight, bool cloud, stp_set_use* use, double* nearest);
/// The use of a set that is not decided yet: none of it is drawn, and the node is opened.
stp_set_use stp_select_begin_use(const stp_selection* s, const stp_select_rule* rule, uint32_t set);
/// Replaces the use of a set by that of the coarse method, where it is a small share of the set and the other one is here.
void stp_select_use_coarse(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                           stp_set_use* use);

/// What to do with the set of a node (which has one), where splats are drawn by size.
stp_set_use stp_select_use_set(const stp_selection* s, const stp_select_entry* at,
                               const stp_sight* sight);
