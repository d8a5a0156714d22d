// SPDX-License-Identifier: MIT
// The leaves of sets that were built leaf by leaf. Each set has a table in its own block
// (docs/format.md, Leaves).
#pragma once

#include "base/splats/leaf_tree.h"
#include "store/file/store.h"

/// The leaves of a set.
typedef struct stp_store_leaves {
    uint32_t leaf_count; ///< 0: none, or not available
    const stp_splat_leaf* leaves;
    uint32_t node_count;
    const stp_leaf_node* nodes; ///< the tree over them; the first node is the root
} stp_store_leaves;

/// Number of leaves that the file lists for a set.
uint32_t stp_store_leaf_count(const stp_store* store, uint32_t set);
/// Verifies the block on first use and builds the tree. Gives no leaves if the set has none or they
/// are not available: a partial file, or not loaded yet (store/residency/residency.h). @return STP_OK,
/// STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_get_leaves(stp_store* store, uint32_t set,
                                             stp_store_leaves* leaves);
