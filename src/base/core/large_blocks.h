// SPDX-License-Identifier: MIT
//
// Allocates large blocks directly from the system. malloc would keep freed memory in fragments:
// after some hours, resident memory may be twice the memory in use. Here, freed blocks return to
// the system immediately, except a few that are kept for reuse, because page faults of new pages
// are expensive. Kept blocks are split for smaller requests and merged with adjacent ones, so
// repeated work finds the same memory again. Each call passes the maximum number of kept bytes, so
// that used and kept memory together stay within one limit.
#pragma once

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

enum { STP_LARGE_KEPT_LIMIT = 128 };

typedef struct stp_large_block {
    void* memory;
    size_t size;
} stp_large_block;

typedef struct stp_large_blocks {
    pthread_mutex_t mutex;
    stp_large_block kept[STP_LARGE_KEPT_LIMIT]; ///< oldest first; the oldest is freed first
    size_t kept_count, kept_bytes;
} stp_large_blocks;

void stp_large_blocks_open(stp_large_blocks* blocks);
/// Frees all kept blocks. Blocks in use stay valid.
void stp_large_blocks_close(stp_large_blocks* blocks);

/// Uninitialised, page-aligned; NULL if the system is out of memory. Afterwards at most `max_kept`
/// bytes are kept. Any thread.
void* stp_large_alloc(stp_large_blocks* blocks, size_t size, size_t max_kept);
/// `size` as requested from stp_large_alloc. Any thread.
void stp_large_free(stp_large_blocks* blocks, void* memory, size_t size, size_t max_kept);

/// Returns all whole pages in a range to the system. Their content is lost; the memory stays valid.
/// The range must belong to the caller alone.
void stp_large_discard(void* memory, size_t size);
