// SPDX-License-Identifier: MIT
#pragma once

#include "base/core/context.h"

/// Many small allocations with one lifetime: free all at once, or back to a mark. Blocks are kept
/// until stp_arena_destroy, so a warm arena does not allocate. Not thread-safe.
typedef struct stp_arena_block stp_arena_block;

typedef struct stp_arena {
    stp_context* context;
    stp_arena_block* first;
    stp_arena_block* current;
    size_t block_size;
} stp_arena;

typedef struct stp_arena_mark {
    stp_arena_block* block;
    size_t block_used;
} stp_arena_mark;

/// `block_size`: bytes requested from the context at a time; larger allocations get their own
/// block.
stp_arena stp_arena_create(stp_context* context, size_t block_size);
void stp_arena_destroy(stp_arena* arena);

/// 16-byte aligned, uninitialised; NULL if out of memory. Every caller checks.
void* stp_arena_alloc(stp_arena* arena, size_t size);
/// Room for `count` elements of `size` bytes; NULL also when their product overflows.
void* stp_arena_alloc_array(stp_arena* arena, size_t count, size_t size);
/// A copy of `length` bytes with a zero byte after them.
char* stp_arena_copy_text(stp_arena* arena, const char* text, size_t length);

stp_arena_mark stp_arena_get_mark(const stp_arena* arena);
void stp_arena_rewind(stp_arena* arena, stp_arena_mark mark);

#define STP_ARENA_ARRAY(arena, type, count)                                                        \
    ((type*)stp_arena_alloc_array((arena), (count), sizeof(type)))
