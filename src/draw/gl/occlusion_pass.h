// SPDX-License-Identifier: MIT
//
// Two passes over what is drawn, as the processor has them, without ever waiting: commands whose boxes are behind the depths of
// the picture before are set aside; when the rest is drawn, its own depths make a pyramid, and what of the others is not
// behind that is drawn too. Both are decided by compute shaders, which write the commands' counts of instances. The picture
// is the same as without.
#pragma once

#include "draw/gl/gl.h"
#include "select/view_frame.h"

struct gl_renderer;
struct view_block;

typedef struct gl_occlusion_pass {
    GLuint cull, fill;      ///< programs; made when they are needed
    GLuint pyramid;         ///< levels of blocks, floats
    GLuint counters;        ///< commands that were set aside: at first, and to the end
    uint32_t width, height; ///< that the pyramid is of
    bool known;             ///< it is of a picture
    bool culls;             ///< the last sample was drawn in two passes
    stp_view_frame frame;   ///< of that picture, and what else leads to its pixels
    double shift_x, shift_y, nearness_scale;
} gl_occlusion_pass;

void gl_occlusion_pass_destroy(struct gl_renderer* r);

/// Whether this sample can be drawn in two passes: of one eye, in perspective, without a filter (which blends hidden splats)
/// and without points of a fixed size.
bool gl_occlusion_pass_serves(const struct gl_renderer* r);
/// What the view's block holds of it.
void gl_occlusion_pass_set_view(const struct gl_renderer* r, struct view_block* view);
/// Sets aside what the pyramid hides (`late` false: one of an earlier picture), or draws, of what was set aside, what this
/// one's pyramid does not hide. @return as gl_program_create
STP_MUST_USE stp_result gl_occlusion_pass_cull(struct gl_renderer* r, bool late);
/// The pyramid of what is drawn so far. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, as gl_program_create; logged
STP_MUST_USE stp_result gl_occlusion_pass_fill(struct gl_renderer* r);
