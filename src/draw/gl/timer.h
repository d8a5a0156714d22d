// SPDX-License-Identifier: MIT
//
// How long the graphics processor takes, without ever waiting for it: times of a frame are known some frames later.
#pragma once

#include "draw/gl/gl.h"

typedef enum gl_timer_point {
    GL_TIMER_BEGIN,
    GL_TIMER_DRAWN,
    GL_TIMER_SHADED,
    GL_TIMER_POINTS
} gl_timer_point;

enum { TIMER_FRAMES = 6 };

/// All zero at first.
typedef struct gl_timer {
    GLuint queries[TIMER_FRAMES][GL_TIMER_POINTS];
    GLuint samples[TIMER_FRAMES]; ///< of the visibility buffer that were written
    uint32_t first, count;        ///< frames that are asked about
    bool known;                   ///< there are times
    double draw_ms, shade_ms;     ///< of the last frame that is known
    uint64_t fragments;
} gl_timer;

void gl_timer_create(const stp_gl* gl, gl_timer* timer);
void gl_timer_destroy(const stp_gl* gl, gl_timer* timer);
/// At the begin, a frame that cannot be timed, since too many are under way, is left out.
/// @return whether it is timed
bool gl_timer_begin(const stp_gl* gl, gl_timer* timer);
void gl_timer_mark(const stp_gl* gl, const gl_timer* timer, gl_timer_point point);
void gl_timer_end(const stp_gl* gl, gl_timer* timer);
/// Takes in what is known by now; `wait`: all.
void gl_timer_read(const stp_gl* gl, gl_timer* timer, bool wait);
