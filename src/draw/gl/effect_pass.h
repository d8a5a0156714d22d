// SPDX-License-Identifier: MIT
//
// What is done with a picture once it is shaded: the processor's eye-dome lighting and ambient occlusion (draw/effect_shape.h)
// as compute passes over how near pixels are.
#pragma once

#include "draw/gl/gl.h"

#include <stipple/base.h>

struct gl_renderer;

/// Programs and planes are made when they are first needed. All zero at first.
typedef struct gl_effect_pass {
    GLuint window, blocks, shades, blur, darken;
    GLuint buffer;                         ///< effect_block
    GLuint planes[2], block_plane, two[2]; ///< of an eye: nearness; blocks of it; what shades
    uint32_t width, height;                ///< of the planes
} gl_effect_pass;

void gl_effect_pass_destroy(struct gl_renderer* r);
/// Darkens the picture of the eye that was shaded last, where the style wants it.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result gl_effect_pass_draw(struct gl_renderer* r);
