// SPDX-License-Identifier: MIT
//
// Post-shading effects: the same eye-dome lighting and ambient occlusion as on the CPU
// (draw/effect_shape.h), as compute passes over pixel nearness.
#pragma once

#include "draw/gl/gl.h"

#include <stipple/base.h>

struct stp_gl_renderer;

/// Programs and planes are created on first use. Zero-initialize it.
typedef struct stp_gl_effect_pass {
    GLuint window, blocks, shades, blur, darken;
    GLuint buffer;                         ///< effect_block
    GLuint planes[2], block_plane, two[2]; ///< an eye's nearness; its blocks; shading factors
    uint32_t width, height;                ///< size of the planes
} stp_gl_effect_pass;

void stp_gl_effect_pass_destroy(struct stp_gl_renderer* r);
/// Darkens the picture of the last shaded eye, if the style enables it.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result stp_gl_effect_pass_draw(struct stp_gl_renderer* r);
