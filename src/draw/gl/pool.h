// SPDX-License-Identifier: MIT
//
// GPU memory for scene data: a few large buffers (pages), suballocated by stp_gl_spans. A word's
// address has the page number in its high bits and the offset within the page below, so shaders
// address everything with one number (shaders/lib_fetch.glsl).
//
// Evicts the least recently used entries; never those used by this frame.
#pragma once

#include "draw/gl/gl.h"
#include "draw/gl/ring.h"
#include "draw/gl/spans.h"

enum { POOL_PAGES_MAX = 8 };

#define POOL_NONE UINT32_MAX

/// An item that can be stored in the pool: an octave, a mesh, a texture, ...
typedef struct stp_gl_entry {
    uint32_t address; ///< POOL_NONE: not resident
    uint32_t span;
    uint32_t used_frame;
    uint32_t previous, next; ///< in order of use
} stp_gl_entry;

typedef struct stp_gl_pool {
    stp_context* context;
    const stp_gl* gl;
    stp_gl_spans spans;
    GLuint pages[POOL_PAGES_MAX];
    uint32_t page_count, page_shift; ///< words of a page: 2^page_shift
    uint32_t first_words;            ///< words of the first page: fewer for a small scene
    uint64_t limit_words;
    stp_gl_entry* entries;
    size_t entry_count;
    uint32_t first_used,
        last_used; ///< least and most recently used entries; POOL_NONE: none resident
    uint32_t frame;
    stp_gl_ring ring; ///< staging ring for uploads
} stp_gl_pool;

/// Creates no page yet. `scene_bytes`: estimate of everything that may be stored.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_pool_create(stp_context* context, const stp_gl* gl,
                                           size_t entry_count, uint64_t limit_bytes,
                                           uint64_t scene_bytes, stp_gl_pool* pool);
void stp_gl_pool_destroy(stp_gl_pool* pool);

void stp_gl_pool_begin_frame(stp_gl_pool* pool);
/// Marks a resident entry as used by the frame.
void stp_gl_pool_use(stp_gl_pool* pool, uint32_t entry);

/// Allocates `words` for an entry that is not resident, and evicts others if needed. @return false
/// if the data of this frame leaves no room, or a page is too small
STP_MUST_USE bool stp_gl_pool_take(stp_gl_pool* pool, uint32_t entry, uint64_t words);
/// Removes a resident entry.
void stp_gl_pool_drop(stp_gl_pool* pool, uint32_t entry);

/// Returns space in the ring for up to POOL_PART_WORDS; follow with stp_gl_pool_copy. @return false if
/// the context is lost
STP_MUST_USE bool stp_gl_pool_write(stp_gl_pool* pool, uint64_t words, stp_gl_ring_part* part);
/// Copies words of a part, from its word `offset` on, to an address.
void stp_gl_pool_copy(stp_gl_pool* pool, const stp_gl_ring_part* part, uint32_t offset,
                      uint32_t address, uint64_t words);

enum { POOL_PART_WORDS = 1 << 20 }; ///< maximum words of stp_gl_pool_write

static inline bool stp_gl_pool_has(const stp_gl_pool* pool, uint32_t entry)
{
    return pool->entries[entry].address != POOL_NONE;
}
