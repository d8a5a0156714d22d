// SPDX-License-Identifier: MIT
#include "program/viewer/model/refinement.h"

static const double finest_ms = 6000.0; // no finer picture is started if it would take longer
static const double whole_ms = 250.0;   // splats shrink in one step at rest if that takes no longer

static float finest_of(const paint_request* request)
{
    return request->quality.splat_size > 0.0f ? request->quality.splat_size : 1.0f;
}

/// Splat size of the next frame at rest: the finest, or in steps while that would take long. Frames
/// at rest have all effects.
static float choose_rest_size(const refinement* r, float finest, const stp_budget* budget)
{
    float half = 0.5f * r->size;
    double whole = stp_budget_predict_whole(budget, (double)finest);
    return half > finest && whole > whole_ms ? half : finest;
}

float refinement_size(const refinement* r, const paint_request* request, const stp_budget* budget)
{
    float finest = finest_of(request);
    if (!(request->budget_ms > 0.0) || r->stage == STAGE_ACCUMULATES) {
        return r->stage == STAGE_ACCUMULATES && request->budget_ms > 0.0 ? r->size : finest;
    }
    return r->stage == STAGE_MOVES ? stp_max(stp_budget_splat_size(budget), finest)
                                   : choose_rest_size(r, finest, budget);
}

stp_draw_style refinement_style(const refinement* r, const paint_request* request,
                                const stp_budget* budget, bool transparent)
{
    const uint32_t layers = 1u << STP_EFFECT_LAYERS, glass = layers | 1u << STP_EFFECT_NEAREST;
    if (r->stage != STAGE_MOVES) {
        return request->style;
    }
    uint32_t left_out = request->budget_ms > 0.0 ? stp_budget_left_out(budget) : layers;
    left_out &= transparent ? ~0u : ~glass;
    stp_draw_style style = stp_draw_style_without(&request->style, left_out);
    style.pixel_filter = !request->quality.reference;
    return style;
}

static refinement_stage next_stage(const refinement* r, const paint_request* request,
                                   const stp_budget* budget, const paint_figures* figures)
{
    float finest = finest_of(request);
    if (r->stage == STAGE_ACCUMULATES) {
        return figures->samples >= request->samples * request->samples ? STAGE_DONE
                                                                       : STAGE_ACCUMULATES;
    }
    if (request->budget_ms > 0.0 && r->size > finest) {
        double size = (double)choose_rest_size(r, finest, budget);
        return stp_budget_predict_whole(budget, size) < finest_ms ? STAGE_RESTS : STAGE_DONE;
    }
    if (request->samples > 1) {
        return STAGE_ACCUMULATES;
    }
    return r->stage == STAGE_MOVES && r->left_out ? STAGE_RESTS // once more, with all effects
                                                  : STAGE_DONE;
}

void refinement_advance(refinement* r, const paint_request* request, const stp_budget* budget,
                        const paint_figures* figures)
{
    r->stage = next_stage(r, request, budget, figures);
}
