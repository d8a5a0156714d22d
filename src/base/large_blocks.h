// SPDX-License-Identifier: MIT
//
// Large blocks of memory straight from the system. Malloc keeps freed memory for later use, in
// pieces; after some hours, resident memory may be twice what is in use. Here a freed block returns
// to the system at once, except for a few that are kept for reuse because fresh pages cost a fault
// each. Every call states how many bytes may be kept, so that used and kept bytes together stay
// within one limit.
#pragma once

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>

enum { STP_LARGE_KEPT_LIMIT = 32 };

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

/// Uninitialised, page-aligned; NULL if the system is out of memory. Afterwards at most `most_kept`
/// bytes are kept. Any thread.
void* stp_large_alloc(stp_large_blocks* blocks, size_t size, size_t most_kept);
/// `size` as requested from stp_large_alloc. Any thread.
void stp_large_free(stp_large_blocks* blocks, void* memory, size_t size, size_t most_kept);
