// SPDX-License-Identifier: MIT
#include "lab/bench/gl_measure.h"

#include "draw/gl/gl.h"
#include "lab/bench/bench.h"

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
