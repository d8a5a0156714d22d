// SPDX-License-Identifier: MIT
//
// Two-pass occlusion culling, as on the CPU, without waiting for the GPU. Commands whose boxes are
// behind the previous picture's depths are deferred. The depths of the first pass then form a
// pyramid, and deferred commands that it does not occlude are drawn too. Compute shaders decide
// both by writing the commands' instance counts. The picture is the same as without culling.
#pragma once

#include "draw/gl/gl.h"
#include "select/view_frame.h"

struct stp_gl_renderer;
struct view_block;

typedef struct stp_gl_occlusion_pass {
    GLuint cull, fill;      ///< programs; created on first use
    GLuint pyramid;         ///< levels of blocks, floats
    GLuint counters;        ///< commands deferred after the first pass, and culled in the end
    uint32_t width, height; ///< view of the pyramid
    bool known;             ///< it is valid
    bool culls;             ///< the last sample was drawn in two passes
    stp_view_frame frame;   ///< frame of the pyramid's picture; then the rest of its projection
    double shift_x, shift_y, nearness_scale;
} stp_gl_occlusion_pass;

void stp_gl_occlusion_pass_destroy(struct stp_gl_renderer* r);

/// Whether this sample can be drawn in two passes: one eye, perspective, no filter (which blends
/// occluded splats), and no fixed-size points.
bool stp_gl_occlusion_pass_serves(const struct stp_gl_renderer* r);
/// Fills its part of the view block.
void stp_gl_occlusion_pass_set_view(const struct stp_gl_renderer* r, struct view_block* view);
/// `late` false: defers commands that the pyramid of an earlier picture occludes. `late` true:
/// draws deferred commands that this picture's pyramid does not occlude. @return as
/// stp_gl_program_create
STP_MUST_USE stp_result stp_gl_occlusion_pass_cull(struct stp_gl_renderer* r, bool late);
/// Builds the pyramid of everything drawn so far. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, as
/// stp_gl_program_create; logged
STP_MUST_USE stp_result stp_gl_occlusion_pass_fill(struct stp_gl_renderer* r);
