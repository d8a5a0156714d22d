// SPDX-License-Identifier: MIT
//
// Large blocks of memory straight from the system. Malloc keeps what is freed for its own later use, in pieces: after
// some hours as much again may be resident as is in use. Here a freed block goes back at once, but for a few that
// are kept to be used again, because fresh pages cost a fault each. A kept block is divided where less is asked for, and
// joined with kept ones beside it, so work that repeats itself finds the same memory again. How many bytes that may be is said every time, so
// that what is in use and what is kept stay within one limit together.
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

/// Uninitialised, page-aligned; NULL if the system is out of memory. Afterwards at most `most_kept`
/// bytes are kept. Any thread.
void* stp_large_alloc(stp_large_blocks* blocks, size_t size, size_t most_kept);
/// `size` as requested from stp_large_alloc. Any thread.
void stp_large_free(stp_large_blocks* blocks, void* memory, size_t size, size_t most_kept);

/// Gives back the pages that lie wholly within: what was in them is lost, and the memory stays valid. Any memory that is
/// its caller's alone.
void stp_large_forget(void* memory, size_t size);
