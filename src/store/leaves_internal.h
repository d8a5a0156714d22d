// SPDX-License-Identifier: MIT
// Leaves, for the files that load them.
#pragma once

#include "store/internal.h"
#include "store/leaves.h"

/// The block of a set's leaves; NULL: it has none.
const stp_store_block* stp_store_leaves_block(const stp_store* store, uint32_t set);
/// Memory that so many leaves take, with the tree over them.
uint64_t stp_store_leaves_bytes(uint32_t leaf_count);
/// Makes the tree behind a set's leaves, which lie at the beginning of their memory.
/// @return what is wrong with the leaves, or NULL. Any thread
const char* stp_store_open_leaves(const stp_store* store, uint32_t set, void* memory,
                                  stp_store_leaves* leaves);
/// What stp_store_get_leaves gives from now on; NULL: none.
void stp_store_publish_leaves(const stp_store* store, uint32_t set, const stp_store_leaves* leaves);
/// Frees what a store without a residency has loaded.
void stp_store_release_leaves(stp_store* store);
