// SPDX-License-Identifier: MIT
// Point trees drawn on the CPU with one thread, for `stipple-lab bench spt`: by recursive traversal,
// which passes blocks of selected points to the rasterizer as QSplat does, and as a sequence, with
// and without groups.
#pragma once

#include "lab/spt/spt_model.h"

typedef struct spt_drawing spt_drawing;

/// The model outlives the drawing. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result spt_drawing_create(spt_model* model, spt_drawing** drawing);
void spt_drawing_destroy(spt_drawing* drawing);

/// Adds the figures of a view. `nodes` has room for all leaves.
void spt_drawing_measure(spt_drawing* drawing, uint32_t* nodes, const spt_view* view,
                         spt_times* times);
