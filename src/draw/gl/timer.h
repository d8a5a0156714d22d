// SPDX-License-Identifier: MIT
//
// GPU times without waiting: the times of a frame are known some frames later.
#pragma once

#include "draw/gl/gl.h"

typedef enum stp_gl_timer_point {
    GL_TIMER_BEGIN,
    GL_TIMER_DRAWN,
    GL_TIMER_LIT,     ///< surfaces are shaded, and caps are drawn
    GL_TIMER_EFFECTS, ///< eye-dome lighting and ambient occlusion are applied
    GL_TIMER_LAYERED, ///< layers of transparent surfaces are composited
    GL_TIMER_SHADED,
    GL_TIMER_POINTS
} stp_gl_timer_point;

/// Draws whose splats are counted.
typedef enum stp_gl_counted {
    GL_COUNTED_POINTS,      ///< of the first pass
    GL_COUNTED_LATE_POINTS, ///< of the pass after the occlusion test
    GL_COUNTED_GLASS,       ///< of the first layer
    GL_COUNTED_LARGE,       ///< two triangles each
    GL_COUNTED_LARGE_GLASS, ///< of the first layer, likewise
    GL_COUNTED_DRAWS
} stp_gl_counted;

enum { TIMER_FRAMES = 6 };

/// Zero-initialize it.
typedef struct stp_gl_timer {
    GLuint queries[TIMER_FRAMES][GL_TIMER_POINTS];
    GLuint samples[TIMER_FRAMES];                  ///< pixels written to the visibility buffer
    GLuint splats[TIMER_FRAMES][GL_COUNTED_DRAWS]; ///< primitives that reach the picture
    uint32_t counted[TIMER_FRAMES];                ///< a bit for each of `splats` that was begun
    bool counts;                                   ///< the driver counts primitives
    bool active;                                   ///< a frame is begun and not ended
    uint32_t first, count;                         ///< frames with pending queries
    bool known;                                    ///< times are valid
    double draw_ms, shade_ms;                      ///< times of the last completed frame
    double effect_ms, layer_ms;                    ///< parts of shade_ms
    uint64_t fragments;
    uint64_t drawn_splats; ///< that the graphics pipeline drew
} stp_gl_timer;

void stp_gl_timer_create(const stp_gl* gl, stp_gl_timer* timer);
void stp_gl_timer_destroy(const stp_gl* gl, stp_gl_timer* timer);
/// Starts timing a frame. Skips the frame if too many queries are pending.
/// @return whether it is timed
bool stp_gl_timer_begin(const stp_gl* gl, stp_gl_timer* timer);
void stp_gl_timer_mark(const stp_gl* gl, const stp_gl_timer* timer, stp_gl_timer_point point);
void stp_gl_timer_end(const stp_gl* gl, stp_gl_timer* timer);
/// Counts the splats of the draw calls until stp_gl_timer_end_count, if the frame is timed.
void stp_gl_timer_begin_count(const stp_gl* gl, stp_gl_timer* timer, stp_gl_counted draw);
void stp_gl_timer_end_count(const stp_gl* gl, const stp_gl_timer* timer);
/// Collects finished queries; `wait`: waits for all.
void stp_gl_timer_read(const stp_gl* gl, stp_gl_timer* timer, bool wait);
