// SPDX-License-Identifier: MIT
// The leaves of sets that were made leaf by leaf: a table for each set, in a block of its own (docs/format.md, Leaves).
#pragma once

#include "store/leaf_tree.h"
#include "store/store.h"

/// Of a set.
typedef struct stp_store_leaves {
    uint32_t leaf_count; ///< 0: there are none, or they are not here
    const stp_splat_leaf* leaves;
    uint32_t node_count;
    const stp_leaf_node* nodes; ///< the tree over them; the first is its root
} stp_store_leaves;

/// The leaves that the file lists for a set; 0: none.
uint32_t stp_store_leaf_count(const stp_store* store, uint32_t set);
/// Checks the block on first use, and makes the tree. None where the set has none, or where they are not here: of a file cut
/// short, or not loaded yet (store/residency.h). @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_get_leaves(stp_store* store, uint32_t set,
                                             stp_store_leaves* leaves);
