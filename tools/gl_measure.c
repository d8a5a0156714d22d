// SPDX-License-Identifier: MIT
#include "gl_measure.h"

#include "bench.h"

#include "base/clock.h"
#include "draw/gl/gl.h"
#include "draw/gl/select_pass.h"

enum { COPIES = 5, SELECTIONS = 7 };

static bool load(const stp_headless* headless, stp_gl* gl)
{
    const stp_draw_gl_desc desc = {.get_proc_address = stp_headless_get_proc_address,
                                   .user = (void*)(uintptr_t)headless};
    return stp_gl_load(gl, &desc) == NULL;
}

/// Between two time stamps; waits.
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

static stp_result select_both(stp_context* context, gl_select_pass* pass, const stp_view* view,
                              const stp_quality* quality, gl_select_times* times)
{
    double cpu[SELECTIONS], gpu[SELECTIONS];
    stp_draw_list list = {.items = NULL};
    gl_select_counts counts = {0};
    GLuint queries[2];
    stp_result result = STP_OK;
    pass->gl->CreateQueries(GL_TIMESTAMP, 2, queries);
    for (int i = -1; i < SELECTIONS && result == STP_OK; ++i) {
        int at = i < 0 ? 0 : i;
        double start = stp_clock_ms();
        result = stp_select(context, pass->store, view, quality, &list);
        cpu[at] = stp_clock_ms() - start;
        times->items = list.count;
        pass->gl->QueryCounter(queries[0], GL_TIMESTAMP);
        result = result == STP_OK ? gl_select_run(pass, view, quality) : result;
        pass->gl->QueryCounter(queries[1], GL_TIMESTAMP);
        gpu[at] = read_ms(pass->gl, queries);
    }
    pass->gl->DeleteQueries(2, queries);
    result = result == STP_OK ? gl_select_read(pass, &list, &counts) : result;
    times->same = result == STP_OK && list.count == times->items;
    times->nodes = counts.visited;
    times->cpu_ms = bench_median(cpu, SELECTIONS);
    times->gpu_ms = bench_median(gpu, SELECTIONS);
    stp_draw_list_destroy(context, &list);
    return result;
}

stp_result gl_measure_select(stp_context* context, const stp_headless* headless,
                             const stp_store* store, const stp_view* view, float splat_size,
                             gl_select_times* times)
{
    const stp_quality quality = {.splat_size = splat_size};
    gl_select_pass pass;
    stp_gl gl;
    *times = (gl_select_times){0};
    if (!load(headless, &gl)) {
        return STP_ERROR_UNSUPPORTED;
    }
    stp_result result = gl_select_create(context, &gl, store, &pass);
    if (result == STP_OK) {
        result = select_both(context, &pass, view, &quality, times);
        gl_select_destroy(&pass);
    }
    return result;
}
