// SPDX-License-Identifier: MIT
#include "lab/bench/memory_speed.h"

#include "base/core/clock.h"
#include "base/math/rng.h"
#include "draw/gl/gl.h"
#include "lab/bench/bench.h"

#include <assert.h>
#include <string.h>

enum {
    COPY_BYTES = 1 << 26, ///< size of each buffer: twice the largest caches
    COPY_TASK = 1 << 20,
    UPDATES = 1 << 22,
    UPDATE_TASK = 1 << 14,
};

bool memory_speed_create(stp_context* context, uint32_t pixel_count, memory_speed* memory)
{
    uint32_t threads = stp_context_thread_count(context);
    *memory = (memory_speed){.context = context, .pixel_count = pixel_count, .threads = threads};
    memory->from = STP_NEW_ARRAY(context, uint8_t, COPY_BYTES);
    memory->to = STP_NEW_ARRAY(context, uint8_t, COPY_BYTES);
    memory->places = STP_NEW_ARRAY(context, uint32_t, UPDATES);
    memory->pixels = STP_NEW_ARRAY(context, uint64_t, (size_t)pixel_count * threads);
    if (memory->from == NULL || memory->to == NULL || memory->places == NULL ||
        memory->pixels == NULL) {
        memory_speed_destroy(memory);
        return false;
    }
    memset(memory->from, 1, COPY_BYTES); // so that the pages are there
    memset(memory->to, 2, COPY_BYTES);
    for (uint32_t i = 0; i < UPDATES; ++i) {
        memory->places[i] = stp_rng_below(7, i, pixel_count);
    }
    return true;
}

void memory_speed_destroy(memory_speed* memory)
{
    stp_free(memory->context, memory->from);
    stp_free(memory->context, memory->to);
    stp_free(memory->context, memory->places);
    stp_free(memory->context, memory->pixels);
    *memory = (memory_speed){0};
}

static void copy_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    memory_speed* m = user;
    (void)worker;
    memcpy(m->to + begin, m->from + begin, end - begin);
}

double memory_speed_copy(memory_speed* memory)
{
    double start = stp_clock_ms();
    stp_parallel_for(memory->context, COPY_BYTES, COPY_TASK, copy_task, memory);
    return 2.0 * COPY_BYTES / (stp_clock_ms() - start) * 1000.0;
}

static void update_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    memory_speed* m = user;
    assert(worker < m->threads && "each worker has its own picture");
    uint64_t* pixels = m->pixels + (size_t)worker * m->pixel_count;
    for (size_t i = begin; i < end; ++i) {
        uint64_t value = stp_rng_hash(3, i), *pixel = &pixels[m->places[i]];
        *pixel = value < *pixel ? value : *pixel;
    }
}

double memory_speed_update(memory_speed* memory)
{
    memset(memory->pixels, 0xff,
           (size_t)memory->pixel_count * memory->threads * sizeof(memory->pixels[0]));
    double start = stp_clock_ms();
    stp_parallel_for(memory->context, UPDATES, UPDATE_TASK, update_task, memory);
    return UPDATES / (stp_clock_ms() - start) * 1000.0;
}

enum { COPIES = 5 };

static bool load(const stp_headless* headless, stp_gl* gl)
{
    const stp_draw_gl_desc desc = {.get_proc_address = stp_headless_get_proc_address,
                                   .user = (void*)(uintptr_t)headless};
    return stp_gl_load(gl, &desc) == NULL;
}

/// Milliseconds between two time stamps; waits for them.
static double read_ms(const stp_gl* gl, const GLuint queries[2])
{
    GLuint64 begin = 0, end = 0;
    gl->GetQueryObjectui64v(queries[0], GL_QUERY_RESULT, &begin);
    gl->GetQueryObjectui64v(queries[1], GL_QUERY_RESULT, &end);
    return (double)(end - begin) * 1e-6;
}

double gl_measure_copy(const stp_headless* headless, uint64_t size)
{
    stp_gl gl;
    GLuint buffers[2], queries[2];
    double ms[COPIES];
    if (!load(headless, &gl)) {
        return 0.0;
    }
    gl.CreateBuffers(2, buffers);
    gl.CreateQueries(GL_TIMESTAMP, 2, queries);
    gl.NamedBufferStorage(buffers[0], (GLsizeiptr)size, NULL, 0);
    gl.NamedBufferStorage(buffers[1], (GLsizeiptr)size, NULL, 0);
    for (int i = -1; i < COPIES; ++i) { // the first finds nothing ready
        gl.QueryCounter(queries[0], GL_TIMESTAMP);
        gl.CopyNamedBufferSubData(buffers[0], buffers[1], 0, 0, (GLsizeiptr)size);
        gl.QueryCounter(queries[1], GL_TIMESTAMP);
        ms[i < 0 ? 0 : i] = read_ms(&gl, queries);
    }
    gl.DeleteQueries(2, queries);
    gl.DeleteBuffers(2, buffers);
    double median = bench_median(ms, COPIES);
    return median > 0.0 ? 2e3 * (double)size / median : 0.0;
}
