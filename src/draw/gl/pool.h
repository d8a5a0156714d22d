// SPDX-License-Identifier: MIT
//
// Graphics memory for what scenes are made of: a few large buffers (pages), shared out by gl_spans. A word's address is the
// page's number above its place in the page, so shaders reach everything with one number (shaders/lib_fetch.glsl).
//
// What was not used for longest gives way to what is needed now; what this frame uses never does.
#pragma once

#include "draw/gl/gl.h"
#include "draw/gl/ring.h"
#include "draw/gl/spans.h"

enum { POOL_PAGES_MOST = 8 };

#define POOL_NONE UINT32_MAX

/// Something that can lie in the pool: an octave, a mesh, a texture, ...
typedef struct gl_entry {
    uint32_t address; ///< POOL_NONE: not here
    uint32_t span;
    uint32_t used_frame;
    uint32_t previous, next; ///< in the order of use
} gl_entry;

typedef struct gl_pool {
    stp_context* context;
    const stp_gl* gl;
    gl_spans spans;
    GLuint pages[POOL_PAGES_MOST];
    uint32_t page_count, page_shift; ///< words of a page: 2^page_shift
    uint64_t limit_words;
    gl_entry* entries;
    size_t entry_count;
    uint32_t first_used,
        last_used; ///< the entry used longest ago, and last; POOL_NONE: none is here
    uint32_t frame;
    gl_ring ring;            ///< that uploads go through
    uint64_t uploaded_bytes; ///< since whoever uses it set it to zero
    uint64_t dropped;        ///< entries that gave way, in all
} gl_pool;

/// Makes no page yet. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_pool_create(stp_context* context, const stp_gl* gl, size_t entry_count,
                                       uint64_t limit_bytes, gl_pool* pool);
void gl_pool_destroy(gl_pool* pool);

void gl_pool_begin_frame(gl_pool* pool);
/// Notes that the frame uses an entry that is here.
void gl_pool_use(gl_pool* pool, uint32_t entry);

/// Takes `words` for an entry that is not here. Others give way where need be.
/// @return false where what this frame uses leaves no room
STP_MUST_USE bool gl_pool_take(gl_pool* pool, uint32_t entry, uint64_t words);
/// Forgets an entry that is here.
void gl_pool_drop(gl_pool* pool, uint32_t entry);

/// Room in the ring to write up to POOL_PART_WORDS to, and then gl_pool_send. @return false where the context is lost
STP_MUST_USE bool gl_pool_write(gl_pool* pool, uint64_t words, gl_ring_part* part);
void gl_pool_send(gl_pool* pool, const gl_ring_part* part, uint32_t address, uint64_t words);

enum { POOL_PART_WORDS = 1 << 20 }; ///< most words of gl_pool_write

static inline bool gl_pool_has(const gl_pool* pool, uint32_t entry)
{
    return pool->entries[entry].address != POOL_NONE;
}
