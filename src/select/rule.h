// SPDX-License-Identifier: MIT
//
// The rules of methods: what a view draws of a set, and from what depth on it suffices. Everything else of a selection
// (what is seen, hidden, resident) is the same for all.
#pragma once

#include "select/select_internal.h"

typedef struct stp_select_rule {
    /// How the set of a node that the eye is not within is used, where no number of splats is asked for.
    /// `use` names the set, and says that it is opened; use->per_depth is above 0.
    void (*use)(const stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                bool cloud, stp_set_use* use);
    /// Uses the first `count` splats wherever they are.
    void (*use_count)(stp_set_use* use, uint32_t count);
    /// Changes how a set is used where only its first `here` splats are there, or the node could not be opened: then all of it
    /// is drawn, from `nearest` on.
    void (*limit)(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use);
    /// Appends the item of a set, with its runs.
    stp_result (*add)(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_sight* sight);
} stp_select_rule;

extern const stp_select_rule stp_select_rule_blue, stp_select_rule_spt;

/// By the id of a method (STP_METHOD_*); that of `blue` for others.
const stp_select_rule* stp_select_rule_of(uint32_t id);

/// What to do with the set of a node (which has one).
stp_set_use stp_select_use_set(const stp_selection* s, const stp_select_entry* at,
                               const stp_sight* sight);
