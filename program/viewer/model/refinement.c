// SPDX-License-Identifier: MIT
#include "program/viewer/model/refinement.h"

static const double finest_ms = 6000.0; // no finer picture is started if it would take longer
static const double whole_ms = 250.0;   // splats shrink in one step at rest if that takes no longer
// A step with larger splats must take at most this part of the time: effects take as long in it.
static const double step_part = 2.0 / 3.0;
enum {
    SHOWN_SAMPLES = 4
}; // fewer accumulated samples are noisier than the filtered picture before

static float finest_of(const paint_request* request)
{
    return request->quality.splat_size > 0.0f ? request->quality.splat_size : 1.0f;
}

/// Effects that a picture at rest with this splat size goes without, because it would take too long:
/// the dearest ones.
static uint32_t choose_left_out(const stp_budget* budget, double size)
{
    const uint32_t layers = 1u << STP_EFFECT_LAYERS, nearest = 1u << STP_EFFECT_NEAREST;
    uint32_t chosen = 0, before;
    do {
        before = chosen;
        double least = stp_budget_predict_whole(budget, size, before);
        for (uint32_t i = 0; i < STP_EFFECT_COUNT && least >= finest_ms; ++i) {
            uint32_t bits = before | 1u << i;
            bool possible = (bits & nearest) == 0 || (bits & layers) != 0;
            double time = stp_budget_predict_whole(budget, size, bits);
            if (possible && time < least) {
                least = time;
                chosen = bits;
            }
        }
    } while (chosen != before);
    return chosen;
}

/// Predicted time of a picture at rest.
static double predict_rest(const stp_budget* budget, double size)
{
    return stp_budget_predict_whole(budget, size, choose_left_out(budget, size));
}

/// Splat size of the next frame at rest: the finest, or in steps where the step comes much earlier.
static float choose_rest_size(const refinement* r, float finest, const stp_budget* budget)
{
    float half = 0.5f * r->size;
    double whole = predict_rest(budget, (double)finest);
    bool pays = whole >= finest_ms || predict_rest(budget, (double)half) < step_part * whole;
    return half > finest && whole > whole_ms && pays ? half : finest;
}

float refinement_size(const refinement* r, const paint_request* request, const stp_budget* budget)
{
    float finest = finest_of(request);
    if (!(request->budget_ms > 0.0) || r->stage == STAGE_ACCUMULATES) {
        return r->stage == STAGE_ACCUMULATES && request->budget_ms > 0.0 ? r->size : finest;
    }
    return r->stage == STAGE_MOVES
               ? stp_max(stp_budget_splat_size(budget), finest * stp_budget_resolution(budget))
               : choose_rest_size(r, finest, budget);
}

static refinement_stage next_stage(const refinement* r, const paint_request* request,
                                   const stp_budget* budget, uint32_t samples)
{
    float finest = finest_of(request);
    if (r->stage == STAGE_ACCUMULATES) {
        return samples >= request->samples * request->samples ? STAGE_DONE : STAGE_ACCUMULATES;
    }
    if (request->budget_ms > 0.0 && r->size > finest) {
        double size = (double)choose_rest_size(r, finest, budget);
        return predict_rest(budget, size) < finest_ms ? STAGE_RESTS : STAGE_DONE;
    }
    if (request->samples > 1) {
        return STAGE_ACCUMULATES;
    }
    return r->stage == STAGE_MOVES && r->left_out ? STAGE_RESTS // once more, with all effects
                                                  : STAGE_DONE;
}

/// Whether a finer picture follows the next frame, which is at rest.
static bool has_finer(const refinement* r, const paint_request* request, const stp_budget* budget)
{
    refinement drawn = *r;
    drawn.size = refinement_size(r, request, budget);
    return next_stage(&drawn, request, budget, 1) != STAGE_DONE;
}

stp_draw_style refinement_style(const refinement* r, const paint_request* request,
                                const stp_budget* budget, bool transparent)
{
    const uint32_t layers = 1u << STP_EFFECT_LAYERS, glass = layers | 1u << STP_EFFECT_NEAREST;
    bool limited = request->budget_ms > 0.0, moves = r->stage == STAGE_MOVES;
    uint32_t left_out = 0;
    if (moves) {
        left_out = limited ? stp_budget_left_out(budget) : layers;
    } else if (limited) {
        left_out = choose_left_out(budget, (double)refinement_size(r, request, budget));
    }
    left_out &= transparent ? ~0u : ~glass;
    stp_draw_style style = stp_draw_style_without(&request->style, left_out);
    style.resolution = moves && limited ? stp_budget_resolution(budget) : 0.0f;
    style.pixel_filter = !request->quality.reference && r->stage != STAGE_ACCUMULATES &&
                         (moves || has_finer(r, request, budget));
    return style;
}

bool refinement_shows(const refinement* r, const paint_request* request, uint32_t samples)
{
    uint32_t all = request->samples * request->samples;
    bool filtered = !request->quality.reference; // the picture before
    return r->stage != STAGE_ACCUMULATES || !filtered || samples >= all || samples >= SHOWN_SAMPLES;
}

void refinement_advance(refinement* r, const paint_request* request, const stp_budget* budget,
                        const paint_figures* figures)
{
    r->stage = next_stage(r, request, budget, figures->samples);
}
