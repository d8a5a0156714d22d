// SPDX-License-Identifier: MIT
//
// Blends overlapping splats: in two more passes after the visibility buffer (STP_FILTER_EWA), or in
// one pass that replaces it (STP_FILTER_BLEND, STP_FILTER_TEXTURED). Both produce sums of weighted
// colours, which shading divides by the sums of weights.
#pragma once

#include "draw/gl/gl.h"

struct stp_gl_renderer;

typedef struct stp_gl_filter_pass {
    GLuint planes_program, blend;              ///< for two passes; 0: not created yet
    GLuint tolerant, textured, tolerant_merge; ///< for one pass
    GLuint splat_texture;                      ///< R8; 0: not created yet
    GLuint vertex_array;
    GLuint planes, sums, framebuffer; ///< textures, RGBA32F; framebuffer of `sums`
    GLuint merged, ids;               ///< a framebuffer of the target's ids, sums and nearness
    GLuint pixels;                    ///< tolerant_pixel
    uint64_t bytes;                   ///< size of `pixels`
    uint32_t width, height;
} stp_gl_filter_pass;

void stp_gl_filter_pass_destroy(struct stp_gl_renderer* r);

/// Whether the style's filter blends in one pass.
bool stp_gl_filter_is_tolerant(const struct stp_gl_renderer* r);

/// Call after the visibility buffer is drawn. @return STP_OK, STP_ERROR_OUT_OF_MEMORY,
/// STP_ERROR_UNSUPPORTED; logged
STP_MUST_USE stp_result stp_gl_filter_pass_blend(struct stp_gl_renderer* r);

/// Draws the splats' part of the visibility buffer and their colours in one pass. @return as
/// stp_gl_filter_pass_blend
STP_MUST_USE stp_result stp_gl_filter_pass_draw_tolerant(struct stp_gl_renderer* r);

/// Binds the blended colours for shading.
void stp_gl_filter_pass_bind(struct stp_gl_renderer* r);
