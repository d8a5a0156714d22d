// SPDX-License-Identifier: MIT
// OpenGL pictures, kept in textures that the window shows while the next one is drawn.
#pragma once

#include "draw/draw_gl.h"

enum { PAINTER_GL_SLOTS = 3 };

typedef struct painter_gl_functions painter_gl_functions;

typedef struct painter_gl {
    painter_gl_functions* functions; ///< NULL: OpenGL is not available
    uint32_t textures[PAINTER_GL_SLOTS];
    uint32_t width[PAINTER_GL_SLOTS], height[PAINTER_GL_SLOTS];
} painter_gl;

// These need a current context.
bool painter_gl_create(painter_gl* g, const stp_draw_gl_desc* desc);
void painter_gl_destroy(painter_gl* g);
/// Copies a picture into a slot's texture and waits for completion. @return the texture; 0: out of
/// memory
uint32_t painter_gl_keep(painter_gl* g, int slot, uint32_t picture, uint32_t width,
                         uint32_t height);
