// SPDX-License-Identifier: MIT
// A count of splats, shared among sets.
#pragma once

#include "select/select_internal.h"

/// Notes the set of a node, which has splats, as one that gets some of the count.
STP_MUST_USE stp_result stp_select_note_set(stp_selection* s, const stp_select_entry* at);

/// Shares the count among the sets that were noted, and appends their items.
STP_MUST_USE stp_result stp_select_add_count(stp_selection* s);
