// SPDX-License-Identifier: MIT
#include "base/core/arena.h"

#include <assert.h>
#include <stdalign.h>
#include <string.h>

#define ARENA_ALIGNMENT ((size_t)16)

struct stp_arena_block {
    stp_arena_block* next;
    size_t capacity;
    size_t used;
    alignas(16) unsigned char data[];
};

stp_arena stp_arena_create(stp_context* context, size_t block_size)
{
    return (stp_arena){.context = context, .block_size = block_size};
}

void stp_arena_destroy(stp_arena* arena)
{
    for (stp_arena_block* block = arena->first; block != NULL;) {
        stp_arena_block* next = block->next;
        stp_free(arena->context, block);
        block = next;
    }
    arena->first = arena->current = NULL;
}

// Moves to a block with room for `size` bytes. Adds one if the next is missing or too small.
static stp_arena_block* next_block(stp_arena* arena, size_t size)
{
    stp_arena_block** link = arena->current != NULL ? &arena->current->next : &arena->first;
    if (*link != NULL && (*link)->capacity >= size) {
        (*link)->used = 0;
        return *link;
    }
    size_t capacity = size > arena->block_size ? size : arena->block_size;
    if (capacity > SIZE_MAX - sizeof(stp_arena_block)) {
        return NULL;
    }
    stp_arena_block* block = stp_alloc(arena->context, sizeof(*block) + capacity);
    if (block != NULL) {
        *block = (stp_arena_block){.next = *link, .capacity = capacity};
        *link = block;
    }
    return block;
}

void* stp_arena_alloc(stp_arena* arena, size_t size)
{
    if (size > SIZE_MAX - ARENA_ALIGNMENT) {
        return NULL;
    }
    size = (size + ARENA_ALIGNMENT - 1) & ~(ARENA_ALIGNMENT - 1);
    if (arena->current == NULL || arena->current->capacity - arena->current->used < size) {
        stp_arena_block* block = next_block(arena, size);
        if (block == NULL) {
            return NULL;
        }
        arena->current = block;
    }
    void* memory = arena->current->data + arena->current->used;
    assert((uintptr_t)memory % ARENA_ALIGNMENT == 0);
    arena->current->used += size;
    assert(arena->current->used <= arena->current->capacity);
    return memory;
}

void* stp_arena_alloc_array(stp_arena* arena, size_t count, size_t size)
{
    return size != 0 && count > SIZE_MAX / size ? NULL : stp_arena_alloc(arena, count * size);
}

char* stp_arena_copy_text(stp_arena* arena, const char* text, size_t length)
{
    char* copy = length == SIZE_MAX ? NULL : stp_arena_alloc(arena, length + 1);
    if (copy != NULL) {
        memcpy(copy, text, length);
        copy[length] = 0;
    }
    return copy;
}

stp_arena_mark stp_arena_get_mark(const stp_arena* arena)
{
    size_t used = arena->current != NULL ? arena->current->used : 0;
    return (stp_arena_mark){.block = arena->current, .block_used = used};
}

void stp_arena_rewind(stp_arena* arena, stp_arena_mark mark)
{
    arena->current = mark.block;
    if (mark.block != NULL) {
        assert(mark.block_used <= mark.block->used && "marks are used in reverse order");
        mark.block->used = mark.block_used;
    }
}
