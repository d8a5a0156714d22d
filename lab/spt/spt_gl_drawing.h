// SPDX-License-Identifier: MIT
// Point trees drawn with OpenGL into the visibility buffer, for `stipple-lab bench spt`: by recursive
// traversal, which fills blocks of points and draws each with one call as QSplat does, and as a
// sequence by the renderer itself, with and without groups. Shaders and state are the same.
#pragma once

#include "lab/spt/spt_model.h"

typedef struct spt_gl_drawing spt_gl_drawing;

/// The model outlives the drawing. @return STP_OK, or an error, which is printed
STP_MUST_USE stp_result spt_gl_drawing_create(spt_model* model, spt_gl_drawing** drawing);
void spt_gl_drawing_destroy(spt_gl_drawing* drawing);

/// Adds the figures of a view, measured until OpenGL has finished. `nodes` has room for all leaves.
/// @return STP_OK, or as stp_renderer_draw
STP_MUST_USE stp_result spt_gl_drawing_measure(spt_gl_drawing* drawing, uint32_t* nodes,
                                               const spt_view* view, spt_times* times);
/// Name of the OpenGL device.
const char* spt_gl_drawing_device(const spt_gl_drawing* drawing);
