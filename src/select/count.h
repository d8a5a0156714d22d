// SPDX-License-Identifier: MIT
// Distributes a splat count over sets.
#pragma once

#include "select/select_internal.h"

/// Registers the set of a node, which has splats, for a share of the count.
STP_MUST_USE stp_result stp_select_note_set(stp_selection* s, const stp_select_entry* at);

/// Distributes the count over the registered sets, and appends their items.
STP_MUST_USE stp_result stp_select_add_count(stp_selection* s);
