// SPDX-License-Identifier: MIT
// The blocks of an open file: the table that lists them, and their bytes.
#pragma once

#include "store/file/store_state.h"

/// Whether the file holds a whole block; false only for partial files.
bool stp_store_is_block_here(const stp_store* store, const stp_store_block* block);
/// Entry of the block table.
const stp_store_block* stp_store_block_at(const stp_store* store, uint32_t index);
/// Reports an index out of range: STP_ERROR_ARGUMENT.
stp_result stp_store_fail_index(const stp_store* store, const char* what, uint32_t index);
/// Reads a part of the mapped file (stp_store_block_source); `user` is the store.
bool stp_store_read_mapped(void* user, uint64_t offset, void* bytes, size_t size);
/// Reports a damaged or missing block: STP_ERROR_FORMAT, STP_ERROR_TRUNCATED.
stp_result stp_store_fail_block(const stp_store* store, const stp_store_block* block,
                                const char* what);
/// Verifies that a block is complete and undamaged. Returns its first byte in `bytes`.
STP_MUST_USE stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                               const unsigned char** bytes);

// Pointers into a block's bytes. Only clusters are checked: @return what is wrong, or NULL.
void stp_store_find_mesh_columns(uint32_t present, const unsigned char* bytes,
                                 stp_store_mesh* mesh);
void stp_store_find_point_columns(uint32_t present, const unsigned char* bytes,
                                  stp_store_point_set* points);
/// Of a level also the number of one-sided triangles.
const char* stp_store_find_clusters(const stp_store* store, uint32_t index,
                                    const unsigned char* bytes, stp_clusters* clusters);
