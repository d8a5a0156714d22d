// SPDX-License-Identifier: MIT
//
// How the pictures of a request become finer: in motion, splats and effects follow the budget of the
// frame's time. At rest, all effects are there unless they take seconds, splats shrink, in steps
// where these save much time, and samples are accumulated.
#pragma once

#include "program/viewer/model/paint_thread.h"

/// Progress of a request's picture.
typedef enum refinement_stage {
    STAGE_MOVES, ///< the first picture of a request
    STAGE_RESTS,
    STAGE_ACCUMULATES,
    STAGE_DONE
} refinement_stage;

/// All zero at first.
typedef struct refinement {
    refinement_stage stage; ///< of the next frame
    float size;             ///< splat size of the last frame
    bool left_out;          ///< the last frame had fewer effects than the request, for lack of time
} refinement;

/// Splat size of the next frame. `budget` is unused if the request has none.
float refinement_size(const refinement* r, const paint_request* request, const stp_budget* budget);

/// Style of the next frame. Without a limit of its time, a moving picture has one layer of
/// transparent surfaces. At rest, effects that would take seconds are left out, the dearest ones
/// first. Pictures are filtered until the last stage. @param transparent  whether the scene has
/// transparent surfaces
stp_draw_style refinement_style(const refinement* r, const paint_request* request,
                                const stp_budget* budget, bool transparent);

/// Whether a drawn frame is shown, before refinement_advance: the first accumulated samples are
/// noisier than the filtered picture before them. @param samples  accumulated so far
bool refinement_shows(const refinement* r, const paint_request* request, uint32_t samples);

/// Goes to the stage after a frame. Samples are accumulated however long a frame takes: a machine
/// that is busy for a moment, or a driver that compiles, must not decide what is seen at rest, and
/// the next request stops it.
void refinement_advance(refinement* r, const paint_request* request, const stp_budget* budget,
                        const paint_figures* figures);
