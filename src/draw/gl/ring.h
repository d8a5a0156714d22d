// SPDX-License-Identifier: MIT
//
// Ring buffer that the CPU writes and the GPU reads, persistently mapped. Parts are allocated in
// order; a part is reused once a fence signals that all its readers are done.
#pragma once

#include "draw/gl/gl.h"

enum { RING_FENCES = 64 };

typedef struct stp_gl_ring_part {
    void* memory;
    GLintptr offset; ///< in the buffer
} stp_gl_ring_part;

/// Zero-initialize it.
typedef struct stp_gl_ring {
    GLuint buffer;
    unsigned char* memory;
    uint64_t size;
    uint64_t head; ///< bytes allocated in total; the position is this modulo the size
    uint64_t tail; ///< bytes freed in total
    uint64_t marked;
    struct {
        GLsync sync;
        uint64_t head;
    } fences[RING_FENCES];
    uint32_t first_fence, fence_count;
    uint64_t waits; ///< number of times the CPU waited for the GPU
} stp_gl_ring;

/// @return false if out of memory
STP_MUST_USE bool stp_gl_ring_create(const stp_gl* gl, uint64_t size, stp_gl_ring* ring);
void stp_gl_ring_destroy(const stp_gl* gl, stp_gl_ring* ring);

/// Allocates `size` bytes, at most half of the ring, aligned to 256. Waits only if the GPU has not
/// yet read that part. Commands that read it must be issued before the next allocation. @return
/// false if the context is lost
STP_MUST_USE bool stp_gl_ring_take(const stp_gl* gl, stp_gl_ring* ring, uint64_t size,
                                   stp_gl_ring_part* part);

/// Inserts a fence. Call after the commands that read the parts allocated so far.
void stp_gl_ring_mark(const stp_gl* gl, stp_gl_ring* ring);
