// SPDX-License-Identifier: MIT
#include "draw/gl/splat_choice.h"

#include "base/core/clock.h"
#include "base/core/context.h"
#include "base/math/rng.h"
#include "draw/gl/gl_renderer.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

enum {
    SOFTWARE_SPLATS = 4096,
    HARDWARE_SPLATS = 131072,
    COMMAND_SPLATS = 4096, ///< splats per command
    REPEATS = 3,
};

const float stp_gl_splat_sizes[SPLAT_SIZES] = {1.0f, 3.0f, 8.0f};

/// Synthetic splats all over the picture, in a separate buffer.
typedef struct made_splats {
    GLuint buffer;
    uint32_t count, commands;
    GLintptr items, records, end; ///< the page's words come first
    stp_gl_splat_source source;
} made_splats;

static GLintptr round_up(size_t offset)
{
    return (GLintptr)((offset + 255) / 256 * 256);
}

static void lay_out(made_splats* s)
{
    assert(s->count % COMMAND_SPLATS == 0 && "all commands are full");
    s->commands = s->count / COMMAND_SPLATS;
    s->items = round_up((size_t)s->count * 3 * sizeof(uint32_t));
    s->records = round_up((size_t)s->items + sizeof(item_block));
    s->source.offset = round_up((size_t)s->records + s->commands * sizeof(record_block));
    s->source.count_offset =
        round_up((size_t)s->source.offset + s->commands * sizeof(struct stp_gl_command));
    s->source.groups_offset = round_up((size_t)s->source.count_offset + sizeof(uint32_t));
    s->end = round_up((size_t)s->source.groups_offset + s->commands * sizeof(uint32_t));
    s->source.count = s->commands;
    s->source.groups = stp_gl_raster_groups(s->count);
}

static void fill(const made_splats* s, unsigned char* memory)
{
    uint32_t* words = (uint32_t*)(void*)memory;
    for (uint32_t i = 0; i < s->count; ++i) {
        uint64_t bits = stp_rng_hash(5, i);
        words[2 * i] = (uint32_t)bits;
        words[2 * i + 1] = (uint32_t)(bits >> 32) & 0x1F1FFFFFu; // roughly facing the eye
        words[2 * s->count + i] = 0xFF808080u;
    }
    record_block* records = (record_block*)(void*)(memory + s->records);
    struct stp_gl_command* commands = (struct stp_gl_command*)(void*)(memory + s->source.offset);
    uint32_t* groups = (uint32_t*)(void*)(memory + s->source.groups_offset);
    for (uint32_t i = 0; i < s->commands; ++i) {
        uint32_t first = i * COMMAND_SPLATS;
        records[i] = (record_block){.first = first,
                                    .address = 2 * first,
                                    .share = 1.0f,
                                    .nearest = -HUGE_VALF,
                                    .farthest = HUGE_VALF};
        commands[i] = (struct stp_gl_command){COMMAND_SPLATS, 1, 0, i};
        groups[i] = (uint32_t)stp_gl_raster_groups(first);
    }
    memcpy(memory + s->source.count_offset, &s->commands, sizeof(s->commands));
}

static stp_result make_splats(stp_gl_renderer* r, made_splats* s)
{
    const stp_gl* gl = &r->gl;
    *s = (made_splats){.count = r->is_software ? SOFTWARE_SPLATS : HARDWARE_SPLATS};
    lay_out(s);
    unsigned char* memory = STP_NEW_ZEROED(r->base.context, unsigned char, (size_t)s->end);
    if (memory == NULL) {
        return stp_fail_memory(r->base.context);
    }
    fill(s, memory);
    gl->CreateBuffers(1, &s->buffer);
    gl->NamedBufferStorage(s->buffer, s->end, memory, GL_DYNAMIC_STORAGE_BIT);
    s->source.buffer = s->buffer;
    stp_free(r->base.context, memory);
    return STP_OK;
}

static void set_size(const stp_gl_renderer* r, const made_splats* s, float size)
{
    float width = (float)r->target.width, height = (float)r->target.height;
    item_block item = {.kind = KIND_SPLATS,
                       .radius_px = 0.5f * size,
                       .center_x = 0.5f * width,
                       .center_y = 0.5f * height,
                       .inverse_scale = 1.0f / height,
                       .slope_factor = 1.0f / height,
                       .rim_depth = 4.0f,
                       .back_depth = 2.0f,
                       .near_w = -1.0f,
                       .nearness_limit = 1.0f,
                       .count = s->count,
                       .colors = 2 * s->count};
    item.rows[0][0] = width / 65536.0f;
    item.rows[1][1] = height / 65536.0f;
    item.rows[2][2] = 1e-6f;
    item.rows[2][3] = 0.4f;
    item.rows[3][3] = 1.0f;
    item.turn[0][0] = item.turn[1][1] = item.turn[2][2] = 1.0f;
    r->gl.NamedBufferSubData(s->buffer, s->items, sizeof(item), &item);
}

static void bind_splats(stp_gl_renderer* r, const made_splats* s)
{
    const stp_gl* gl = &r->gl;
    stp_gl_bind_frame(r);
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_PAGES, s->buffer, 0, s->items);
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_ITEMS, s->buffer, s->items,
                        sizeof(item_block));
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, BINDING_RECORDS, s->buffer, s->records,
                        s->commands * (GLsizeiptr)sizeof(record_block));
}

static stp_result draw_path(stp_gl_renderer* r, stp_gl_splats way,
                            const stp_gl_splat_source* source)
{
    stp_result result = STP_OK;
    if (way == STP_GL_SPLATS_POINTS) {
        result = stp_gl_splat_pass_points(r, source, r->splats.points);
    } else {
        result = stp_gl_raster_pass_draw(r, source);
        stp_gl_set_visible_state(r);
    }
    return result;
}

/// Waits until all issued commands are done.
static void finish(const stp_gl* gl)
{
    GLsync sync = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    while (gl->ClientWaitSync(sync, GL_SYNC_FLUSH_COMMANDS_BIT, UINT64_C(1000000000)) ==
               GL_TIMEOUT_EXPIRED &&
           gl->GetGraphicsResetStatus() == GL_NO_ERROR) {
    }
    gl->DeleteSync(sync);
}

/// Time stamp in nanoseconds. A software renderer may rasterise after its own time stamps: there,
/// waits for completion and reads the CPU clock.
static double read_time(const stp_gl_renderer* r, GLuint query)
{
    GLuint64 now = 0;
    if (r->is_software) {
        finish(&r->gl);
        return stp_clock_ms() * 1e6;
    }
    r->gl.GetQueryObjectui64v(query, GL_QUERY_RESULT, &now);
    return (double)now;
}

/// Minimum of several runs in nanoseconds, after a warm-up.
static stp_result time_path(stp_gl_renderer* r, stp_gl_splats way,
                            const stp_gl_splat_source* source, const GLuint queries[2],
                            double* best)
{
    const stp_gl* gl = &r->gl;
    const GLfloat far = 0.0f;
    stp_result result = STP_OK;
    *best = HUGE_VAL;
    for (int i = 0; i <= REPEATS && result == STP_OK; ++i) {
        gl->ClearNamedFramebufferfv(r->target.framebuffer, GL_DEPTH, 0, &far);
        double begin = r->is_software ? read_time(r, 0) : 0.0;
        gl->QueryCounter(queries[0], GL_TIMESTAMP);
        stp_gl_splat_pass_begin(r);
        result = draw_path(r, way, source);
        gl->QueryCounter(queries[1], GL_TIMESTAMP);
        begin = r->is_software ? begin : read_time(r, queries[0]);
        double took = read_time(r, queries[1]) - begin;
        *best = i > 0 ? fmin(*best, took) : *best;
    }
    return result;
}

static stp_result measure_path(stp_gl_renderer* r, stp_gl_splats way, const made_splats* s,
                               const GLuint queries[2])
{
    stp_gl_splat_choice* c = &r->splat_choice;
    int at = (int)way - 1;
    assert(at >= 0 && at < SPLAT_WAYS && "automatic is no path");
    stp_result result = STP_OK;
    if (way != STP_GL_SPLATS_POINTS) {
        stp_gl_splat_source nothing = s->source;
        nothing.groups = 0;
        bind_splats(r, s);
        result = time_path(r, way, &nothing, queries, &c->fixed_ns[at]);
    }
    for (int i = 0; i < SPLAT_SIZES && result == STP_OK; ++i) {
        double all = 0.0;
        set_size(r, s, stp_gl_splat_sizes[i]);
        bind_splats(r, s);
        result = time_path(r, way, &s->source, queries, &all);
        // nothing is free
        c->splat_ns[at][i] = fmax(all - c->fixed_ns[at], 1.0) / (double)s->count;
    }
    return result;
}

stp_result stp_gl_splat_choice_measure(stp_gl_renderer* r)
{
    stp_gl_splat_choice* c = &r->splat_choice;
    const stp_gl* gl = &r->gl;
    made_splats splats;
    GLuint queries[2];
    if (c->measured || c->wanted != STP_GL_SPLATS_AUTO ||
        r->frame.commands[GL_COMMANDS_SPLATS].count == 0) {
        return STP_OK;
    }
    uint32_t draw_calls = r->draw_calls, dispatches = r->dispatches;
    stp_result result = make_splats(r, &splats);
    if (result != STP_OK) {
        return result;
    }
    gl->CreateQueries(GL_TIMESTAMP, 2, queries);
    stp_gl_set_visible_state(r);
    for (int way = STP_GL_SPLATS_POINTS; way <= STP_GL_SPLATS_COMPUTE && result == STP_OK; ++way) {
        result = measure_path(r, (stp_gl_splats)way, &splats, queries);
    }
    gl->DeleteQueries(2, queries);
    gl->DeleteBuffers(1, &splats.buffer);
    stp_gl_shade_pass_clear_counter(r, GL_COUNTER_SPLATS); // drew none of the picture
    c->measured = result == STP_OK;
    c->pixels = (uint64_t)r->target.width * r->target.height;
    r->draw_calls = draw_calls;
    r->dispatches = dispatches;
    return result;
}

/// Nanoseconds per splat of a size, interpolated between measured sizes.
static double price(const double* splat_ns, float size)
{
    int i = 0;
    while (i + 2 < SPLAT_SIZES && size > stp_gl_splat_sizes[i + 1]) {
        i += 1;
    }
    assert(i + 1 < SPLAT_SIZES && stp_gl_splat_sizes[i] < stp_gl_splat_sizes[i + 1]);
    double part = ((double)size - (double)stp_gl_splat_sizes[i]) /
                  ((double)stp_gl_splat_sizes[i + 1] - (double)stp_gl_splat_sizes[i]);
    part = fmin(fmax(part, 0.0), 1.0);
    return splat_ns[i] + part * (splat_ns[i + 1] - splat_ns[i]);
}

stp_gl_splats stp_gl_splat_choice_find(const stp_gl_renderer* r, uint64_t splats, float size)
{
    const stp_gl_splat_choice* c = &r->splat_choice;
    if (c->wanted != STP_GL_SPLATS_AUTO || !c->measured) {
        return c->wanted != STP_GL_SPLATS_AUTO ? c->wanted : STP_GL_SPLATS_POINTS;
    }
    stp_gl_splats best = STP_GL_SPLATS_POINTS;
    assert(c->pixels > 0 && "costs are those of a picture");
    double pixels = (double)r->target.width * (double)r->target.height / (double)c->pixels;
    double minimum = HUGE_VAL;
    for (int way = STP_GL_SPLATS_POINTS; way <= STP_GL_SPLATS_COMPUTE; ++way) {
        double took =
            c->fixed_ns[way - 1] * pixels + (double)splats * price(c->splat_ns[way - 1], size);
        if (took < minimum) {
            minimum = took;
            best = (stp_gl_splats)way;
        }
    }
    return best;
}

bool stp_gl_splat_source_find(const stp_gl_renderer* r, stp_gl_splat_source* source)
{
    const stp_gl_commands* commands = &r->frame.commands[GL_COMMANDS_SPLATS];
    *source = (stp_gl_splat_source){.buffer = r->frame.buffer,
                                    .offset = commands->offset,
                                    .count_offset = commands->count_offset,
                                    .groups_offset = r->frame.groups_offset,
                                    .groups = r->frame.group_count,
                                    .count = (uint32_t)commands->count};
    return commands->count > 0;
}

stp_result stp_gl_splat_choice_draw(stp_gl_renderer* r, bool late)
{
    stp_gl_splat_choice* c = &r->splat_choice;
    if (!late && !stp_gl_splat_source_find(r, &c->source)) {
        c->source.count = 0;
    }
    if (c->source.count == 0) {
        return STP_OK;
    }
    if (!late) {
        float scale = r->style->splat_scale > 0.0f ? r->style->splat_scale : 1.0f;
        c->used = stp_gl_splat_choice_find(r, r->list->splat_count, r->list->splat_size * scale);
        stp_gl_splat_pass_begin(r);
    }
    // the second pass is small, and an undrawn point costs less than a group that draws nothing
    stp_gl_splats way = late ? STP_GL_SPLATS_POINTS : c->used;
    if (way == STP_GL_SPLATS_POINTS) { // the compute rasteriser counts its splats
        stp_gl_timer_begin_count(&r->gl, &r->timer,
                                 late ? GL_COUNTED_LATE_POINTS : GL_COUNTED_POINTS);
    }
    stp_result result = draw_path(r, way, &c->source);
    if (way == STP_GL_SPLATS_POINTS) {
        stp_gl_timer_end_count(&r->gl, &r->timer);
    }
    stp_gl_bind_frame(r);
    return result;
}

void stp_gl_splat_choice_draw_large(stp_gl_renderer* r)
{
    if (r->splat_choice.source.count > 0) {
        stp_gl_timer_begin_count(&r->gl, &r->timer, GL_COUNTED_LARGE);
        stp_gl_splat_pass_large(r, r->splats.large);
        stp_gl_timer_end_count(&r->gl, &r->timer);
        stp_gl_bind_frame(r);
    }
}

void stp_draw_gl_set_splats(stp_renderer* renderer, stp_gl_splats splats)
{
    ((stp_gl_renderer*)renderer)->splat_choice.wanted = splats;
}

_Static_assert((int)SPLAT_SIZES == (int)STP_GL_SPLAT_SIZES, "sizes reported to the caller");

stp_draw_gl_speed stp_draw_gl_get_speed(const stp_renderer* renderer)
{
    const stp_gl_splat_choice* c = &((const stp_gl_renderer*)renderer)->splat_choice;
    stp_draw_gl_speed speed = {.sizes = {0}};
    memcpy(speed.sizes, stp_gl_splat_sizes, sizeof(speed.sizes));
    memcpy(speed.splat_ns, c->splat_ns, sizeof(speed.splat_ns));
    memcpy(speed.fixed_ns, c->fixed_ns, sizeof(speed.fixed_ns));
    return speed;
}
