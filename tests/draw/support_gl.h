// SPDX-License-Identifier: MIT
// A small scene drawn by both backends. Without OpenGL, tests skip.
#pragma once

#include "support_picture.h"

#include "draw/draw_gl.h"
#include "program/present/headless.h"

typedef struct made_gl {
    made_picture picture; ///< its renderer is the CPU's
    stp_headless headless;
    stp_renderer* renderer;
    uint8_t pixels[PICTURE_SIDE * PICTURE_SIDE * 4];
} made_gl;

/// Four intersecting sheets of splats, one of them with holes, and one square without splats; or
/// (`one`) only the first sheet, which has one colour.
/// @return false if there is no OpenGL, or on failure, with *failed true
bool made_gl_begin(made_gl* m, bool one, bool* failed);
/// The same for another scene, made by `add` (NULL: all the sheets), with other settings (NULL: the
/// default ones; its function loader is ignored), and memory from `heap`.
bool made_gl_begin_with(made_gl* m, void (*add)(made_picture* p), const stp_draw_gl_desc* settings,
                        test_heap* heap, bool* failed);
/// The same for a whole test: fails it on failure. @return false if there is no OpenGL: then nothing
/// is left, and the test is marked as skipped
bool made_gl_begin_or_skip(test_state* test, made_gl* m, void (*add)(made_picture* p),
                           const stp_draw_gl_desc* settings, test_heap* heap);
/// Destroys the renderer and creates another.
stp_result made_gl_renew(made_gl* m, const stp_draw_gl_desc* settings);
/// Draws with OpenGL into `pixels`; fails on a debug message about an error.
stp_result made_gl_draw(made_gl* m);
void made_gl_end(made_gl* m);

/// Number of pixels that differ by more than `levels` in any channel.
int made_count_different(const uint8_t* a, const uint8_t* b, int levels);
