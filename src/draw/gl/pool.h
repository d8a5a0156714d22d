// SPDX-License-Identifier: MIT
//
// GPU memory for scene data: a few large buffers (pages), suballocated by gl_spans. A word's
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
typedef struct gl_entry {
    uint32_t address; ///< POOL_NONE: not resident
    uint32_t span;
    uint32_t used_frame;
    uint32_t previous, next; ///< in order of use
} gl_entry;

typedef struct gl_pool {
    stp_context* context;
    const stp_gl* gl;
    gl_spans spans;
    GLuint pages[POOL_PAGES_MAX];
    uint32_t page_count, page_shift; ///< words of a page: 2^page_shift
    uint32_t first_words;            ///< words of the first page: fewer for a small scene
    uint64_t limit_words;
    gl_entry* entries;
    size_t entry_count;
    uint32_t first_used,
        last_used; ///< least and most recently used entries; POOL_NONE: none resident
    uint32_t frame;
    gl_ring ring;            ///< staging ring for uploads
    uint64_t uploaded_bytes; ///< bytes sent since the renderer set it to 0
    uint64_t dropped;        ///< evicted entries, in total
} gl_pool;

/// Creates no page yet. `scene_bytes`: estimate of everything that may be stored.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_pool_create(stp_context* context, const stp_gl* gl, size_t entry_count,
                                       uint64_t limit_bytes, uint64_t scene_bytes, gl_pool* pool);
void gl_pool_destroy(gl_pool* pool);

void gl_pool_begin_frame(gl_pool* pool);
/// Marks a resident entry as used by the frame.
void gl_pool_use(gl_pool* pool, uint32_t entry);

/// Allocates `words` for an entry that is not resident, and evicts others if needed. @return false
/// if the data of this frame leaves no room, or a page is too small
STP_MUST_USE bool gl_pool_take(gl_pool* pool, uint32_t entry, uint64_t words);
/// Removes a resident entry.
void gl_pool_drop(gl_pool* pool, uint32_t entry);

/// Returns space in the ring for up to POOL_PART_WORDS; follow with gl_pool_send. @return false if
/// the context is lost
STP_MUST_USE bool gl_pool_write(gl_pool* pool, uint64_t words, gl_ring_part* part);
void gl_pool_send(gl_pool* pool, const gl_ring_part* part, uint32_t address, uint64_t words);

enum { POOL_PART_WORDS = 1 << 20 }; ///< maximum words of gl_pool_write

static inline bool gl_pool_has(const gl_pool* pool, uint32_t entry)
{
    return pool->entries[entry].address != POOL_NONE;
}
