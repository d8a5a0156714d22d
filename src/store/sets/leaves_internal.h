// SPDX-License-Identifier: MIT
// Leaves, for the files that load them.
#pragma once

#include "store/file/internal.h"
#include "store/sets/leaves.h"

/// The block of a set's leaves; NULL if it has none.
const stp_store_block* stp_store_leaves_block(const stp_store* store, uint32_t set);
/// Size of this many leaves with their tree.
uint64_t stp_store_leaves_bytes(uint32_t leaf_count);
/// Builds the tree of a set's leaves; the leaves are at the beginning of its memory. Any thread.
/// @return NULL, or the error in the leaves
const char* stp_store_open_leaves(const stp_store* store, uint32_t set, void* memory,
                                  stp_store_leaves* leaves);
/// Sets the result of stp_store_get_leaves; NULL: no leaves.
void stp_store_publish_leaves(const stp_store* store, uint32_t set, const stp_store_leaves* leaves);
/// Frees the leaves loaded by a store without a residency.
void stp_store_release_leaves(stp_store* store);
