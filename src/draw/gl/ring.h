// SPDX-License-Identifier: MIT
//
// Memory that the processor writes and the graphics processor reads, mapped once and for ever. Parts are taken in turn;
// a part may be used again once a fence says that all that read it is done.
#pragma once

#include "draw/gl/gl.h"

enum { RING_FENCES = 64 };

typedef struct gl_ring_part {
    void* memory;
    GLintptr offset; ///< in the buffer
} gl_ring_part;

/// All zero at first.
typedef struct gl_ring {
    GLuint buffer;
    unsigned char* memory;
    uint64_t size;
    uint64_t head; ///< bytes ever taken; the place is that modulo the size
    uint64_t tail; ///< bytes ever free again
    uint64_t marked;
    struct {
        GLsync sync;
        uint64_t head;
    } fences[RING_FENCES];
    uint32_t first_fence, fence_count;
    uint64_t waits; ///< times the processor had to wait for the graphics processor
} gl_ring;

/// @return false where there is no memory
STP_MUST_USE bool gl_ring_create(const stp_gl* gl, uint64_t size, gl_ring* ring);
void gl_ring_destroy(const stp_gl* gl, gl_ring* ring);

/// Room for `size` bytes, which must be at most half of the ring, at a multiple of 256. Waits only where the graphics processor
/// has not yet read what lies there. Commands that read it must be given before the next part is taken.
/// @return false where the context is lost
STP_MUST_USE bool gl_ring_take(const stp_gl* gl, gl_ring* ring, uint64_t size, gl_ring_part* part);

/// After the commands that read what was taken so far.
void gl_ring_mark(const stp_gl* gl, gl_ring* ring);
