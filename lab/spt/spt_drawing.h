// SPDX-License-Identifier: MIT
// Point trees drawn for `stipple-lab bench spt`: on the CPU with one thread, and with OpenGL.
#pragma once

#include "lab/spt/spt_model.h"
#include "store/file/store.h"

// Point trees drawn on the CPU with one thread, for `stipple-lab bench spt`: by recursive traversal,
// which passes blocks of selected points to the rasterizer as QSplat does, and as a sequence, with
// and without groups.

typedef struct spt_drawing spt_drawing;

/// The model outlives the drawing. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result spt_drawing_create(spt_model* model, spt_drawing** drawing);
void spt_drawing_destroy(spt_drawing* drawing);

/// Adds the figures of a view. `nodes` has room for all leaves.
void spt_drawing_measure(spt_drawing* drawing, uint32_t* nodes, const spt_view* view,
                         spt_times* times);

// Point trees drawn with OpenGL into the visibility buffer, for `stipple-lab bench spt`: by recursive
// traversal, which fills blocks of points and draws each with one call as QSplat does, and as a
// sequence by the renderer itself, with and without groups. Shaders and state are the same.

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

// A store that holds one set of splats, for benchmarks of the renderers.

/// Writes a scratch file with one node that has this set of method `spt`, opens it and unlinks it.
/// @return STP_OK, or as stp_store_write and stp_store_open
STP_MUST_USE stp_result spt_store_open(stp_context* context, const stp_splats* set,
                                       stp_store** store);
