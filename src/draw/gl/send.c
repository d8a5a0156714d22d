// SPDX-License-Identifier: MIT
// Uploads the frame's blocks to the GPU: one part of a ring holds all, and is copied to the GPU's
// memory.
#include "base/core/context.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>
#include <string.h>

enum { PART_ALIGNMENT = 256, RING_MIN = 1 << 20, RING_FRAMES = 6, BUFFER_MIN = 1 << 18 };

/// Blocks written consecutively. Offsets are those in the buffer that shaders read.
typedef struct layout {
    stp_gl_ring_part part;
    uint64_t used;
} layout;

static uint64_t round_up(uint64_t size)
{
    return (size + PART_ALIGNMENT - 1) / PART_ALIGNMENT * PART_ALIGNMENT;
}

/// Empty blocks take space too: an empty range cannot be bound.
static GLintptr put(layout* l, const void* from, size_t size)
{
    GLintptr offset = (GLintptr)l->used;
    if (size > 0) {
        memcpy((unsigned char*)l->part.memory + l->used, from, size);
    }
    l->used += round_up(size > 0 ? size : 1);
    return offset;
}

static uint64_t measure(const stp_gl_frame* f)
{
    const size_t sizes[] = {f->item_count * sizeof(*f->items),
                            f->record_count * sizeof(*f->records),
                            f->chunk_count * sizeof(*f->chunks),
                            f->lookup_count * sizeof(*f->lookup),
                            f->commands[GL_COMMANDS_SPLATS].count * sizeof(uint32_t),
                            sizeof(view_block),
                            GL_COMMAND_KINDS * sizeof(uint32_t)};
    uint64_t total = 0;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        total += round_up(sizes[i] > 0 ? sizes[i] : 1);
    }
    for (int i = 0; i < GL_COMMAND_KINDS; ++i) {
        size_t size = f->commands[i].count * sizeof(*f->commands[i].commands);
        total += round_up(size > 0 ? size : 1);
    }
    return total;
}

/// A ring that holds several frames of this size.
static bool make_ring(stp_gl_renderer* r, uint64_t needed)
{
    stp_gl_ring* ring = &r->frame.ring;
    if (needed <= ring->size / 3) {
        return true;
    }
    uint64_t size = RING_MIN;
    while (size < RING_FRAMES * needed) {
        size *= 2;
    }
    stp_gl_ring_destroy(&r->gl, ring);
    return stp_gl_ring_create(&r->gl, size, ring);
}

/// A buffer of the GPU that holds the frame.
static bool make_buffer(stp_gl_renderer* r, uint64_t needed)
{
    const stp_gl* gl = &r->gl;
    stp_gl_frame* f = &r->frame;
    if (needed <= f->buffer_size) {
        return true;
    }
    uint64_t size = BUFFER_MIN;
    while (size < needed) {
        size *= 2;
    }
    gl->DeleteBuffers(1, &f->buffer);
    f->buffer = 0;
    f->buffer_size = 0;
    while (gl->GetError() != GL_NO_ERROR) { // discard errors of earlier calls
    }
    gl->CreateBuffers(1, &f->buffer);
    gl->NamedBufferStorage(f->buffer, (GLsizeiptr)size, NULL, 0);
    gl->ObjectLabel(GL_BUFFER, f->buffer, -1, "frame");
    f->buffer_size = gl->GetError() == GL_NO_ERROR ? size : 0;
    return f->buffer_size > 0;
}

/// The first group of each splat command.
static void put_groups(stp_gl_frame* f, layout* l)
{
    const stp_gl_commands* splats = &f->commands[GL_COMMANDS_SPLATS];
    uint32_t* first = (uint32_t*)(void*)((unsigned char*)l->part.memory + l->used);
    f->group_count = 0;
    for (size_t i = 0; i < splats->count; ++i) {
        first[i] = (uint32_t)f->group_count;
        f->group_count += stp_gl_raster_groups(splats->commands[i].count);
    }
    assert(f->group_count <= UINT32_MAX && "first groups have 32 bits");
    f->groups_offset = (GLintptr)l->used;
    l->used += round_up(splats->count > 0 ? splats->count * sizeof(uint32_t) : 1);
}

static void put_commands(stp_gl_frame* f, layout* l)
{
    uint32_t counts[GL_COMMAND_KINDS];
    for (int i = 0; i < GL_COMMAND_KINDS; ++i) {
        stp_gl_commands* c = &f->commands[i];
        c->offset = put(l, c->commands, c->count * sizeof(*c->commands));
        counts[i] = (uint32_t)c->count;
    }
    GLintptr counts_offset = put(l, counts, sizeof(counts));
    for (int i = 0; i < GL_COMMAND_KINDS; ++i) {
        f->commands[i].count_offset = counts_offset + i * (GLintptr)sizeof(uint32_t);
    }
}

stp_result stp_gl_frame_send(stp_gl_renderer* r, const view_block* view)
{
    const stp_gl* gl = &r->gl;
    stp_gl_frame* f = &r->frame;
    uint64_t needed = measure(f);
    layout l = {.used = 0};
    if (!make_ring(r, needed) || !make_buffer(r, needed) ||
        !stp_gl_ring_take(gl, &f->ring, needed, &l.part)) {
        return stp_fail(r->base.context, STP_ERROR_OUT_OF_MEMORY,
                        "gl: not enough graphics memory for a frame's %zu items", f->item_count);
    }
    f->items_offset = put(&l, f->items, f->item_count * sizeof(*f->items));
    f->records_offset = put(&l, f->records, f->record_count * sizeof(*f->records));
    f->chunks_offset = put(&l, f->chunks, f->chunk_count * sizeof(*f->chunks));
    f->lookup_offset = put(&l, f->lookup, f->lookup_count * sizeof(*f->lookup));
    f->view_offset = put(&l, view, sizeof(*view));
    put_groups(f, &l);
    put_commands(f, &l);
    assert(l.used == needed && "measure() counts all blocks");
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT); // culling wrote the last frame's commands
    gl->CopyNamedBufferSubData(f->ring.buffer, f->buffer, l.part.offset, 0, (GLsizeiptr)l.used);
    return STP_OK;
}

static void bind(const stp_gl_renderer* r, GLuint binding, GLintptr offset, size_t size)
{
    r->gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, r->frame.buffer, offset,
                          (GLsizeiptr)(size > 0 ? size : 16));
}

void stp_gl_bind_frame(stp_gl_renderer* r)
{
    const stp_gl* gl = &r->gl;
    const stp_gl_frame* f = &r->frame;
    for (uint32_t i = 0; i < r->pool.page_count; ++i) {
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_PAGES + i, r->pool.pages[i]);
    }
    bind(r, BINDING_ITEMS, f->items_offset, f->item_count * sizeof(*f->items));
    bind(r, BINDING_RECORDS, f->records_offset, f->record_count * sizeof(*f->records));
    bind(r, BINDING_CHUNKS, f->chunks_offset, f->chunk_count * sizeof(*f->chunks));
    bind(r, BINDING_LOOKUP, f->lookup_offset, f->lookup_count * sizeof(*f->lookup));
    gl->BindBufferRange(GL_UNIFORM_BUFFER, BINDING_VIEW, f->buffer, f->view_offset,
                        sizeof(view_block));
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_LIGHT_MATERIALS, r->light_materials);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING_MATERIALS, r->materials);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, BINDING_NOISE, r->layer_pass.noise);
}
