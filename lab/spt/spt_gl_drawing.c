// SPDX-License-Identifier: MIT
#include "base/core/clock.h"
#include "base/core/context.h"
#include "base/splats/coverage.h"
#include "draw/gl/gl_renderer.h"
#include "lab/spt/spt_drawing.h"
#include "program/drawing/frame.h"

#include <assert.h>
#include <string.h>

enum {
    PLACE_WORDS = 2,
    NODE_WORDS = 3, ///< place and shape
    BLOCK_WORDS = NODE_WORDS * SPT_BLOCK,
};

/// Offsets in the buffer of a traversal, in bytes.
typedef struct buffer_layout {
    GLintptr points, colors, item, records, commands, end;
} buffer_layout;

struct spt_gl_drawing {
    spt_model* model;
    stp_store* store;
    frame_maker maker;
    stp_gl_renderer* renderer; ///< the maker's
    uint32_t* words;           ///< NODE_WORDS a node, as shaders read them
    GLuint buffer;
    unsigned char* memory; ///< persistent mapping of the buffer
    buffer_layout at;
    uint32_t* pixels; ///< ids that were read back
    bool warm;
    stp_draw_item item; ///< of the sequence; the renderer refers to it and to the list
    stp_draw_list list;
};

static GLintptr round_up(size_t offset)
{
    return (GLintptr)((offset + 255) / 256 * 256);
}

static void make_words(const spt_model* m, uint32_t* words)
{
    for (size_t i = 0; i < m->tree->count; ++i) {
        const uint16_t* p = m->positions + 3 * i;
        const uint8_t* n = (const uint8_t*)m->normals + 2 * i;
        words[NODE_WORDS * i] = (uint32_t)p[0] | (uint32_t)p[1] << 16;
        words[NODE_WORDS * i + 1] = (uint32_t)p[2] | (uint32_t)n[0] << 16 | (uint32_t)n[1] << 24;
        words[NODE_WORDS * i + 2] = m->shapes[i];
    }
}

/// A buffer large enough for all blocks of a traversal, so that no block overwrites one that is
/// still being drawn.
static stp_result make_buffer(spt_gl_drawing* d)
{
    const stp_gl* gl = &d->renderer->gl;
    size_t blocks = d->model->tree->count / SPT_BLOCK + 1, points = blocks * SPT_BLOCK;
    const GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    d->at.colors = round_up(points * NODE_WORDS * sizeof(uint32_t));
    d->at.item = round_up((size_t)d->at.colors + points * sizeof(uint32_t));
    d->at.records = round_up((size_t)d->at.item + sizeof(item_block));
    d->at.commands = round_up((size_t)d->at.records + blocks * sizeof(record_block));
    d->at.end = round_up((size_t)d->at.commands + blocks * sizeof(struct stp_gl_command));
    gl->CreateBuffers(1, &d->buffer);
    gl->NamedBufferStorage(d->buffer, d->at.end, NULL, access);
    d->memory = gl->MapNamedBufferRange(d->buffer, 0, d->at.end, access);
    if (d->memory == NULL) {
        return stp_fail(d->model->context, STP_ERROR_OUT_OF_MEMORY,
                        "bench spt: not enough graphics memory for %zu points", points);
    }
    uint32_t* colors = (uint32_t*)(void*)(d->memory + d->at.colors);
    record_block* records = (record_block*)(void*)(d->memory + d->at.records);
    for (size_t i = 0; i < points; ++i) {
        colors[i] = 0x00808080u | (uint32_t)STP_COVERAGE_WHOLE << 24;
    }
    for (size_t i = 0; i < blocks; ++i) {
        records[i] =
            (record_block){.first = (uint32_t)(i * SPT_BLOCK),
                           .address = (uint32_t)(i * BLOCK_WORDS),
                           .options = (uint32_t)(i * BLOCK_WORDS + PLACE_WORDS * SPT_BLOCK),
                           .share = 1.0f,
                           .nearest = -HUGE_VALF,
                           .farthest = HUGE_VALF,
                           .reach = 1.0f};
    }
    return STP_OK;
}

stp_result spt_gl_drawing_create(spt_model* model, spt_gl_drawing** drawing)
{
    stp_context* context = model->context;
    const stp_draw_style style = {0};
    spt_gl_drawing* d = STP_NEW_ZEROED(context, spt_gl_drawing, 1);
    *drawing = d;
    if (d == NULL) {
        return stp_fail_memory(context);
    }
    d->model = model;
    stp_result result = spt_store_open(context, &model->set, &d->store);
    if (result == STP_OK) {
        result = frame_maker_create_on(context, d->store, &style, FRAME_BACKEND_GL, &d->maker);
    }
    if (result != STP_OK) {
        return result;
    }
    d->renderer = (stp_gl_renderer*)d->maker.renderer;
    d->renderer->omits = (stp_gl_omissions){.occlusion = true, .shading = true};
    stp_draw_gl_set_splats(d->maker.renderer, STP_GL_SPLATS_POINTS);
    d->words = STP_NEW_ARRAY(context, uint32_t, NODE_WORDS * (size_t)model->tree->count + 1);
    d->pixels = STP_NEW_ARRAY(context, uint32_t, (size_t)SPT_WIDTH * SPT_HEIGHT);
    if (d->words == NULL || d->pixels == NULL) {
        return stp_fail_memory(context);
    }
    make_words(model, d->words);
    return make_buffer(d);
}

void spt_gl_drawing_destroy(spt_gl_drawing* d)
{
    if (d == NULL) {
        return;
    }
    stp_context* context = d->model->context;
    if (d->memory != NULL) {
        d->renderer->gl.UnmapNamedBuffer(d->buffer);
    }
    if (d->renderer != NULL) {
        d->renderer->gl.DeleteBuffers(1, &d->buffer);
    }
    frame_maker_destroy(&d->maker);
    if (d->store != NULL) {
        stp_store_close(d->store);
    }
    stp_free(context, d->words);
    stp_free(context, d->pixels);
    stp_free(context, d);
}

const char* spt_gl_drawing_device(const spt_gl_drawing* d)
{
    return d->renderer->device;
}

/// Waits until drawing has finished.
static void finish(const stp_gl* gl)
{
    GLsync sync = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    while (gl->ClientWaitSync(sync, GL_SYNC_FLUSH_COMMANDS_BIT, UINT64_C(1000000000)) ==
               GL_TIMEOUT_EXPIRED &&
           gl->GetGraphicsResetStatus() == GL_NO_ERROR) {
    }
    gl->DeleteSync(sync);
}

static uint64_t count_covered(const spt_gl_drawing* d)
{
    const stp_gl_renderer* r = d->renderer;
    uint64_t count = 0, whole = (uint64_t)SPT_WIDTH * SPT_HEIGHT;
    stp_gl_read_texture(&r->gl, r->target.ids, GL_RED_INTEGER, GL_UNSIGNED_INT, SPT_WIDTH,
                        SPT_HEIGHT, whole * sizeof(uint32_t), d->pixels);
    for (size_t i = 0; i < whole; ++i) {
        count += d->pixels[i] != NO_ID ? 1 : 0;
    }
    return count;
}

/// What the renderer does before it draws, for points of the buffer.
static void begin_points(spt_gl_drawing* d)
{
    stp_gl_renderer* r = d->renderer;
    const stp_gl* gl = &r->gl;
    const GLuint nothing[4] = {NO_ID, NO_ID, NO_ID, NO_ID};
    const GLfloat far = 0.0f;
    item_block item = r->frame.items[0]; // draw_sequence made it for the same view
    item.flags = ITEM_SHAPES;
    item.colors = (uint32_t)((size_t)d->at.colors / sizeof(uint32_t));
    memcpy(d->memory + d->at.item, &item, sizeof(item));
    stp_gl_set_visible_state(r);
    stp_gl_bind_frame(r);
    gl->ClearNamedFramebufferuiv(r->target.framebuffer, GL_COLOR, 0, nothing);
    gl->ClearNamedFramebufferfv(r->target.framebuffer, GL_DEPTH, 0, &far);
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_PAGES, d->buffer, 0, d->at.item);
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_ITEMS, d->buffer, d->at.item,
                        sizeof(item));
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_RECORDS, d->buffer, d->at.records,
                        d->at.commands - d->at.records);
    stp_gl_splat_pass_begin(r);
    gl->Enable(GL_PROGRAM_POINT_SIZE);
    gl->BindVertexArray(r->splats.vertex_array);
    gl->UseProgram(r->splats.points);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, d->buffer);
}

static void fill_block(spt_gl_drawing* d, uint32_t block, const uint32_t* nodes, uint32_t count)
{
    uint32_t* places = (uint32_t*)(void*)(d->memory + d->at.points) + (size_t)block * BLOCK_WORDS;
    uint32_t* shapes = places + PLACE_WORDS * SPT_BLOCK;
    assert(count <= SPT_BLOCK && block <= d->model->tree->count / SPT_BLOCK);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t* words = d->words + (size_t)NODE_WORDS * nodes[i];
        places[PLACE_WORDS * i] = words[0];
        places[PLACE_WORDS * i + 1] = words[1];
        shapes[i] = words[2];
    }
    struct stp_gl_command* commands = (struct stp_gl_command*)(void*)(d->memory + d->at.commands);
    commands[block] = (struct stp_gl_command){count, 1, 0, block};
}

static void draw_traversal(spt_gl_drawing* d, uint32_t* nodes, const spt_view* view,
                           spt_times* times)
{
    stp_gl_renderer* r = d->renderer;
    const stp_gl* gl = &r->gl;
    double start = stp_clock_ms();
    begin_points(d);
    double from = stp_clock_ms();
    uint32_t count = stp_point_tree_traverse(d->model->tree, &view->tree, nodes);
    for (uint32_t block = 0; block * SPT_BLOCK < count; ++block) {
        uint32_t begin = block * SPT_BLOCK;
        fill_block(d, block, nodes + begin, count - begin < SPT_BLOCK ? count - begin : SPT_BLOCK);
        times->gather_ms += stp_clock_ms() - from;
        GLintptr of_block = d->at.commands + block * (GLintptr)sizeof(struct stp_gl_command);
        gl->MultiDrawArraysIndirect(GL_POINTS, (const void*)of_block, 1, 0);
        from = stp_clock_ms();
    }
    gl->Disable(GL_PROGRAM_POINT_SIZE);
    stp_gl_splat_pass_large(r, r->splats.large);
    finish(gl);
    stp_gl_leave_state(r);
    times->traversal_ms += stp_clock_ms() - start;
    times->traversal_splats += count;
    times->traversal_pixels += count_covered(d);
}

static stp_result draw_sequence(spt_gl_drawing* d, const spt_view* view, bool grouped,
                                spt_times* times)
{
    stp_gl_renderer* r = d->renderer;
    d->item = (stp_draw_item){.kind = STP_DRAW_SPLATS,
                              .prefix = view->prefix,
                              .full_prefix = view->prefix,
                              .radius = d->model->set.step,
                              .level_per_depth = view->per_depth,
                              .one_sided = grouped,
                              .transform = stp_affine_identity()};
    d->list = (stp_draw_list){
        .items = &d->item, .count = 1, .splat_count = view->prefix, .splat_size = 1.0f};
    const stp_draw_style style = {0};
    stp_draw_stats stats;
    r->omits.groups = !grouped;
    double start = stp_clock_ms();
    stp_result result =
        stp_renderer_draw(d->maker.renderer, &view->view, &d->list, &style, NULL, &stats);
    finish(&r->gl);
    double took = stp_clock_ms() - start;
    start = stp_clock_ms();
    result = result == STP_OK ? stp_gl_frame_make(r) : result; // again, measured alone
    stp_gl_frame_place(r, 0);
    double test_ms = stp_clock_ms() - start;
    const stp_gl_commands* commands = &r->frame.commands[GL_COMMANDS_SPLATS];
    uint64_t submitted = 0;
    for (size_t i = 0; i < commands->count; ++i) {
        submitted += commands->commands[i].count;
    }
    spt_way way = grouped ? SPT_GROUPED : SPT_PLAIN;
    spt_model_pick(d->model, view, way);
    *(grouped ? &times->group_ms : &times->sequence_ms) += took;
    *(grouped ? &times->group_test_ms : &times->test_ms) += test_ms;
    *(grouped ? &times->group_submitted : &times->sequence_submitted) += submitted;
    *(grouped ? &times->group_commands : &times->sequence_commands) += commands->count;
    *(grouped ? &times->group_splats : &times->sequence_splats) +=
        spt_model_count(d->model, view, way);
    *(grouped ? &times->group_pixels : &times->sequence_pixels) += count_covered(d);
    return result;
}

stp_result spt_gl_drawing_measure(spt_gl_drawing* d, uint32_t* nodes, const spt_view* view,
                                  spt_times* times)
{
    if (!d->warm) { // all octaves are brought, and programs made, before anything is measured
        spt_times cold = {0};
        spt_view all = *view;
        all.prefix = d->model->set.count;
        stp_result result = draw_sequence(d, &all, false, &cold);
        if (result != STP_OK) {
            return result;
        }
        draw_traversal(d, nodes, view, &cold);
        d->warm = true;
    }
    stp_result result = draw_sequence(d, view, false, times);
    result = result == STP_OK ? draw_sequence(d, view, true, times) : result;
    if (result == STP_OK) {
        draw_traversal(d, nodes, view, times);
    }
    return result;
}
