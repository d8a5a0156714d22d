// SPDX-License-Identifier: MIT
// Draws section caps (draw/caps.h), which the CPU fills, into a shaded picture.
#pragma once

#include "draw/caps.h"
#include "draw/gl/gl.h"

struct stp_gl_renderer;

/// Created on first use. Zero-initialize it.
typedef struct stp_gl_cap_pass {
    stp_caps* caps;
    GLuint program, nearness, pixels; ///< textures of an eye
    uint32_t width, height;           ///< size of the textures
    bool shows;                       ///< the eye's last shaded picture has caps
} stp_gl_cap_pass;

void stp_gl_cap_pass_destroy(struct stp_gl_renderer* r);
/// Draws the caps of the last shaded eye into its picture and depths, if the style enables them.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED, or what reading the store
/// returns; logged
STP_MUST_USE stp_result stp_gl_cap_pass_draw(struct stp_gl_renderer* r);
