// SPDX-License-Identifier: MIT
// How the pictures of a request become finer, at made-up times.
#include "tests.h"

#include "program/viewer/model/refinement.h"

static const paint_request asked = {
    .style = {.ambient_occlusion = 0.05f}, .budget_ms = 33.0, .samples = 1};

/// A frame of a scene whose detail takes so many milliseconds at size 1, with occlusion where the
/// style has it.
static stp_frame_cost draw(const stp_draw_style* style, float size, double detail_ms,
                           double occlusion_ms)
{
    double finer = 1.0 / ((double)size * (double)size);
    stp_frame_cost cost = {.milliseconds = 1.0 + detail_ms * finer,
                           .splats = (uint64_t)(1e5 * detail_ms * finer),
                           .covered_pixels = 500000,
                           .draw_calls = 100,
                           .splat_size = size};
    if (style->ambient_occlusion > 0.0f) {
        cost.effect_ms[STP_EFFECT_OCCLUSION] = occlusion_ms;
        cost.milliseconds += occlusion_ms;
    }
    return cost;
}

/// Moves for some frames. @return the refinement after the last one
static refinement move(stp_budget* budget, double detail_ms, double occlusion_ms)
{
    refinement r = {0};
    stp_budget_init(budget, STP_CONTROLLER_PREDICT, asked.budget_ms);
    for (int i = 0; i < 100; ++i) {
        r.stage = STAGE_MOVES;
        r.size = refinement_size(&r, &asked, budget);
        stp_draw_style style = refinement_style(&r, &asked, budget, true);
        r.left_out = !stp_draw_style_is_same(&style, &asked.style);
        stp_frame_cost cost = draw(&style, r.size, detail_ms, occlusion_ms);
        stp_budget_update(budget, &cost);
    }
    refinement_advance(&r, &asked, budget, &(paint_figures){.samples = 1});
    return r;
}

void test_refinement_takes_effects_back_in_the_first_frame_at_rest(test_state* test)
{
    stp_budget budget;
    refinement r = move(&budget, 120.0, 20.0);
    CHECK(r.left_out && r.size > 1.5f);
    CHECK_EQUAL(STAGE_RESTS, r.stage);
    const refinement moves = {.stage = STAGE_MOVES};
    CHECK(refinement_style(&moves, &asked, &budget, true).pixel_filter);
    stp_draw_style style = refinement_style(&r, &asked, &budget, true);
    CHECK(stp_draw_style_is_same(&style, &asked.style));
    CHECK(refinement_size(&r, &asked, &budget) == 1.0f); // 141 ms are short enough
}

/// Effects take as long in a step as in the finest picture: a step must come much earlier.
void test_refinement_steps_only_where_a_step_saves_time(test_state* test)
{
    stp_budget budget;
    refinement r = move(&budget, 150.0, 400.0);
    CHECK(r.left_out && r.size > 2.0f);
    CHECK(stp_budget_predict_whole(&budget, 1.0, 0) > 500.0);
    CHECK_EQUAL(STAGE_RESTS, r.stage);
    CHECK(refinement_size(&r, &asked, &budget) == 1.0f); // 4 times fewer splats save a fifth
    r = move(&budget, 600.0, 100.0);
    CHECK(refinement_size(&r, &asked, &budget) == 0.5f * r.size);
    stp_draw_style style = refinement_style(&r, &asked, &budget, true);
    CHECK(style.pixel_filter && style.ambient_occlusion > 0.0f); // a finer picture follows
    r.size = 0.5f * r.size;
    refinement_advance(&r, &asked, &budget, &(paint_figures){.samples = 1});
    CHECK_EQUAL(STAGE_RESTS, r.stage);
}

/// Effects that take seconds do not keep splats coarse, nor the picture filtered.
void test_refinement_goes_without_effects_that_take_seconds(test_state* test)
{
    stp_budget budget;
    refinement r = move(&budget, 150.0, 8000.0);
    CHECK_EQUAL(STAGE_RESTS, r.stage);
    CHECK(r.size > 1.5f && refinement_size(&r, &asked, &budget) == 1.0f);
    stp_draw_style style = refinement_style(&r, &asked, &budget, true);
    CHECK(style.ambient_occlusion == 0.0f && !style.pixel_filter);
    r.size = 1.0f;
    refinement_advance(&r, &asked, &budget, &(paint_figures){.samples = 1});
    CHECK_EQUAL(STAGE_DONE, r.stage);
}

/// Pictures are filtered until the last stage shows several samples.
void test_refinement_shows_no_raw_sample_before_the_last_picture(test_state* test)
{
    paint_request request = asked;
    const stp_budget budget = {0}; // unused
    refinement r = {.stage = STAGE_RESTS, .size = 1.0f};
    request.budget_ms = 0.0;
    CHECK(!refinement_style(&r, &request, &budget, false).pixel_filter); // the last picture
    request.samples = 3;
    CHECK(refinement_style(&r, &request, &budget, false).pixel_filter);
    CHECK(refinement_shows(&r, &request, 1));
    refinement_advance(&r, &request, &budget, &(paint_figures){.samples = 1});
    CHECK_EQUAL(STAGE_ACCUMULATES, r.stage);
    for (uint32_t samples = 1; samples <= 9; ++samples) {
        CHECK(!refinement_style(&r, &request, &budget, false).pixel_filter);
        CHECK_EQUAL(samples >= 4, refinement_shows(&r, &request, samples));
        refinement_advance(&r, &request, &budget, &(paint_figures){.samples = samples});
    }
    CHECK_EQUAL(STAGE_DONE, r.stage);
    r.stage = STAGE_ACCUMULATES;
    request.quality.reference = true; // no picture of exact triangles is filtered
    CHECK(refinement_shows(&r, &request, 1));
}

/// Without a limit of its time, a picture in motion has the nearest layer of transparent surfaces.
void test_refinement_without_a_budget_draws_one_layer_in_motion(test_state* test)
{
    paint_request request = asked;
    const stp_budget budget = {0}; // unused
    refinement r = {0};
    request.budget_ms = 0.0;
    stp_draw_style style = refinement_style(&r, &request, &budget, true);
    CHECK_EQUAL(STP_TRANSPARENCY_NEAREST, style.transparency);
    CHECK(style.ambient_occlusion > 0.0f && refinement_size(&r, &request, &budget) == 1.0f);
    style = refinement_style(&r, &request, &budget, false);
    CHECK_EQUAL(STP_TRANSPARENCY_LAYERS, style.transparency);
    r.left_out = true;
    refinement_advance(&r, &request, &budget, &(paint_figures){.samples = 1});
    CHECK_EQUAL(STAGE_RESTS, r.stage);
}
