// SPDX-License-Identifier: MIT
#include "draw/gl/ring.h"

#include <assert.h>

enum { RING_ALIGNMENT = 256 };

bool stp_gl_ring_create(const stp_gl* gl, uint64_t size, stp_gl_ring* ring)
{
    assert(size > 0 && size % RING_ALIGNMENT == 0 && "parts at its end stay aligned");
    const GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    *ring = (stp_gl_ring){.size = size};
    gl->CreateBuffers(1, &ring->buffer);
    gl->NamedBufferStorage(ring->buffer, (GLsizeiptr)size, NULL, flags);
    ring->memory = gl->MapNamedBufferRange(ring->buffer, 0, (GLsizeiptr)size, flags);
    if (ring->memory == NULL) {
        stp_gl_ring_destroy(gl, ring);
        return false;
    }
    gl->ObjectLabel(GL_BUFFER, ring->buffer, -1, "ring");
    return true;
}

void stp_gl_ring_destroy(const stp_gl* gl, stp_gl_ring* ring)
{
    for (uint32_t i = 0; i < ring->fence_count; ++i) {
        gl->DeleteSync(ring->fences[(ring->first_fence + i) % RING_FENCES].sync);
    }
    if (ring->memory != NULL) {
        gl->UnmapNamedBuffer(ring->buffer);
    }
    if (ring->buffer != 0) {
        gl->DeleteBuffers(1, &ring->buffer);
    }
    *ring = (stp_gl_ring){0};
}

/// Waits for the oldest fence. @return false if there is none, or the context is lost
static bool wait_for_one(const stp_gl* gl, stp_gl_ring* ring)
{
    if (ring->fence_count == 0) {
        return false;
    }
    GLsync sync = ring->fences[ring->first_fence].sync;
    GLenum state = gl->ClientWaitSync(sync, 0, 0);
    if (state == GL_TIMEOUT_EXPIRED) {
        ring->waits += 1;
        do {
            state = gl->ClientWaitSync(sync, GL_SYNC_FLUSH_COMMANDS_BIT, UINT64_C(1000000000));
        } while (state == GL_TIMEOUT_EXPIRED && gl->GetGraphicsResetStatus() == GL_NO_ERROR);
    }
    assert(ring->tail <= ring->fences[ring->first_fence].head && "fences are signalled in order");
    ring->tail = ring->fences[ring->first_fence].head;
    gl->DeleteSync(sync);
    ring->first_fence = (ring->first_fence + 1) % RING_FENCES;
    ring->fence_count -= 1;
    return state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED;
}

bool stp_gl_ring_take(const stp_gl* gl, stp_gl_ring* ring, uint64_t size, stp_gl_ring_part* part)
{
    assert(size <= ring->size / 2 && "larger than a ring can allocate");
    uint64_t begin = (ring->head + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT;
    if (begin % ring->size + size > ring->size) { // no part wraps around the end
        begin = (begin / ring->size + 1) * ring->size;
    }
    while (begin + size > ring->tail + ring->size) {
        if (ring->marked != ring->head && ring->fence_count == 0) {
            stp_gl_ring_mark(gl, ring);
        }
        if (!wait_for_one(gl, ring)) {
            return false;
        }
    }
    ring->head = begin + size;
    assert(ring->tail <= ring->head && ring->head - ring->tail <= ring->size &&
           "nothing unread is overwritten");
    assert(begin % RING_ALIGNMENT == 0 && begin % ring->size + size <= ring->size);
    *part = (stp_gl_ring_part){ring->memory + begin % ring->size, (GLintptr)(begin % ring->size)};
    return true;
}

void stp_gl_ring_mark(const stp_gl* gl, stp_gl_ring* ring)
{
    if (ring->marked == ring->head) {
        return;
    }
    if (ring->fence_count == RING_FENCES && !wait_for_one(gl, ring)) {
        return;
    }
    uint32_t at = (ring->first_fence + ring->fence_count) % RING_FENCES;
    assert(ring->fence_count < RING_FENCES && ring->marked < ring->head);
    ring->fences[at].sync = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    ring->fences[at].head = ring->head;
    ring->fence_count += 1;
    ring->marked = ring->head;
}
