// SPDX-License-Identifier: MIT
#include "draw/gl/timer.h"

#include <assert.h>

void stp_gl_timer_create(const stp_gl* gl, stp_gl_timer* timer)
{
    *timer = (stp_gl_timer){0};
    for (int i = 0; i < TIMER_FRAMES; ++i) {
        gl->CreateQueries(GL_TIMESTAMP, GL_TIMER_POINTS, timer->queries[i]);
    }
    gl->CreateQueries(GL_SAMPLES_PASSED, TIMER_FRAMES, timer->samples);
    timer->counts = stp_gl_has(gl, "GL_ARB_pipeline_statistics_query");
    for (int i = 0; i < TIMER_FRAMES && timer->counts; ++i) {
        gl->GenQueries(GL_COUNTED_DRAWS, timer->splats[i]); // Mesa refuses to create them
    }
}

void stp_gl_timer_destroy(const stp_gl* gl, stp_gl_timer* timer)
{
    gl->DeleteQueries(TIMER_FRAMES * GL_TIMER_POINTS, timer->queries[0]);
    gl->DeleteQueries(TIMER_FRAMES, timer->samples);
    gl->DeleteQueries(TIMER_FRAMES * GL_COUNTED_DRAWS, timer->splats[0]);
    *timer = (stp_gl_timer){0};
}

static uint32_t now_at(const stp_gl_timer* timer)
{
    return (timer->first + timer->count) % TIMER_FRAMES;
}

bool stp_gl_timer_begin(const stp_gl* gl, stp_gl_timer* timer)
{
    stp_gl_timer_read(gl, timer, false);
    if (timer->count == TIMER_FRAMES) {
        return false;
    }
    gl->QueryCounter(timer->queries[now_at(timer)][GL_TIMER_BEGIN], GL_TIMESTAMP);
    gl->BeginQuery(GL_SAMPLES_PASSED, timer->samples[now_at(timer)]);
    timer->counted[now_at(timer)] = 0;
    timer->active = true;
    return true;
}

void stp_gl_timer_begin_count(const stp_gl* gl, stp_gl_timer* timer, stp_gl_counted draw)
{
    if (timer->active && timer->counts) {
        assert((timer->counted[now_at(timer)] >> draw & 1u) == 0 && "once a frame");
        timer->counted[now_at(timer)] |= 1u << draw;
        gl->BeginQuery(GL_CLIPPING_OUTPUT_PRIMITIVES_ARB, timer->splats[now_at(timer)][draw]);
    }
}

void stp_gl_timer_end_count(const stp_gl* gl, const stp_gl_timer* timer)
{
    if (timer->active && timer->counts) {
        gl->EndQuery(GL_CLIPPING_OUTPUT_PRIMITIVES_ARB);
    }
}

void stp_gl_timer_mark(const stp_gl* gl, const stp_gl_timer* timer, stp_gl_timer_point point)
{
    assert(timer->count < TIMER_FRAMES && point != GL_TIMER_BEGIN && "a frame was begun");
    if (point == GL_TIMER_DRAWN) {
        gl->EndQuery(GL_SAMPLES_PASSED);
    }
    gl->QueryCounter(timer->queries[now_at(timer)][point], GL_TIMESTAMP);
}

void stp_gl_timer_end(const stp_gl* gl, stp_gl_timer* timer)
{
    stp_gl_timer_mark(gl, timer, GL_TIMER_SHADED);
    timer->count += 1;
    timer->active = false;
}

static uint64_t read_splats(const stp_gl* gl, const stp_gl_timer* timer)
{
    uint64_t splats = 0;
    for (int i = 0; i < GL_COUNTED_DRAWS; ++i) {
        GLuint64 drawn = 0;
        if ((timer->counted[timer->first] >> i & 1u) != 0) {
            gl->GetQueryObjectui64v(timer->splats[timer->first][i], GL_QUERY_RESULT, &drawn);
        }
        splats += i >= GL_COUNTED_LARGE ? drawn / 2 : drawn;
    }
    return splats;
}

void stp_gl_timer_read(const stp_gl* gl, stp_gl_timer* timer, bool wait)
{
    while (timer->count > 0) {
        const GLuint* queries = timer->queries[timer->first];
        GLuint64 known = 0, at[GL_TIMER_POINTS], fragments = 0;
        gl->GetQueryObjectui64v(queries[GL_TIMER_SHADED], GL_QUERY_RESULT_AVAILABLE, &known);
        if (!known && !wait) {
            return;
        }
        for (int i = 0; i < GL_TIMER_POINTS; ++i) {
            gl->GetQueryObjectui64v(queries[i], GL_QUERY_RESULT, &at[i]);
        }
        gl->GetQueryObjectui64v(timer->samples[timer->first], GL_QUERY_RESULT, &fragments);
        timer->draw_ms = (double)(at[GL_TIMER_DRAWN] - at[GL_TIMER_BEGIN]) * 1e-6;
        timer->shade_ms = (double)(at[GL_TIMER_SHADED] - at[GL_TIMER_DRAWN]) * 1e-6;
        timer->effect_ms = (double)(at[GL_TIMER_EFFECTS] - at[GL_TIMER_LIT]) * 1e-6;
        timer->layer_ms = (double)(at[GL_TIMER_LAYERED] - at[GL_TIMER_EFFECTS]) * 1e-6;
        timer->fragments = fragments;
        timer->drawn_splats = read_splats(gl, timer);
        timer->known = true;
        timer->first = (timer->first + 1) % TIMER_FRAMES;
        timer->count -= 1;
    }
}
