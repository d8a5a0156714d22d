// SPDX-License-Identifier: MIT
// Effects of a frame: their times, and styles without them.
#include "tests.h"

#include "draw/frame_effects.h"

void test_frame_effects_are_split_by_their_times(test_state* test)
{
    stp_draw_style style = {.ambient_occlusion = 0.05f, .supersample = 2};
    stp_draw_stats stats = {.effect_ms = 8.0,
                            .layer_ms = 4.0,
                            .layers = 3,
                            .listed_splats = 7,
                            .triangles = 5,
                            .listed_triangles = 11};
    stp_frame_cost cost = stp_draw_frame_cost(&style, &stats, 2.0f, 28.0);
    CHECK(cost.milliseconds == 28.0 && cost.splats == 7 && cost.splat_size == 2.0f);
    CHECK(cost.triangles == 5 && cost.listed_triangles == 11);
    CHECK(cost.effect_ms[STP_EFFECT_OCCLUSION] == 8.0);
    CHECK(cost.effect_ms[STP_EFFECT_ANTIALIASING] == 15.0); // three of four samples of 5 ms
    CHECK(cost.effect_ms[STP_EFFECT_LAYERS] == 0.75);       // of the remaining sample: three
    CHECK(cost.effect_ms[STP_EFFECT_NEAREST] == 0.25);      // of four passes, and the first
    style.eye_dome = 1.0f;                                  // takes as long without occlusion
    cost = stp_draw_frame_cost(&style, &stats, 2.0f, 28.0);
    CHECK(cost.effect_ms[STP_EFFECT_OCCLUSION] == 0.0);
    style = (stp_draw_style){.transparency = STP_TRANSPARENCY_PATTERN};
    cost = stp_draw_frame_cost(&style, &stats, 2.0f, 28.0);
    for (int i = 0; i < STP_EFFECT_COUNT; ++i) {
        CHECK(cost.effect_ms[i] == 0.0);
    }
}

void test_frame_effects_are_left_out_one_by_one(test_state* test)
{
    const stp_draw_style style = {.ambient_occlusion = 0.05f, .supersample = 4, .eye_dome = 1.0f};
    for (uint32_t bits = 0; bits < 16; ++bits) {
        stp_draw_style less = stp_draw_style_without(&style, bits);
        CHECK((less.ambient_occlusion > 0.0f) == ((bits & 1) == 0));
        CHECK_EQUAL((bits & 2) == 0 ? 4 : 1, less.supersample);
        CHECK_EQUAL((bits & 4) == 0   ? STP_TRANSPARENCY_LAYERS
                    : (bits & 8) == 0 ? STP_TRANSPARENCY_NEAREST
                                      : STP_TRANSPARENCY_PATTERN,
                    less.transparency);
        CHECK(less.eye_dome == 1.0f && less.left_out == bits);
    }
}

/// A style that wants the nearest layer, or a pattern, keeps it, and it is no effect.
void test_frame_effects_keep_what_is_asked_for(test_state* test)
{
    const stp_draw_stats stats = {.layer_ms = 4.0, .layers = 1};
    const stp_draw_style all = {0}, nearest = {.transparency = STP_TRANSPARENCY_NEAREST},
                         pattern = {.transparency = STP_TRANSPARENCY_PATTERN};
    for (uint32_t bits = 0; bits < 16; ++bits) {
        stp_draw_style less = stp_draw_style_without(&nearest, bits);
        CHECK_EQUAL(STP_TRANSPARENCY_PATTERN, stp_draw_style_without(&pattern, bits).transparency);
        CHECK_EQUAL(STP_TRANSPARENCY_NEAREST, less.transparency);
        CHECK_EQUAL(0, less.left_out); // it has no other effect
        stp_frame_cost cost = stp_draw_frame_cost(&less, &stats, 1.0f, 10.0);
        CHECK(cost.effect_ms[STP_EFFECT_NEAREST] == 0.0);
    }
    stp_draw_style one = stp_draw_style_without(&all, 1u << STP_EFFECT_LAYERS);
    stp_frame_cost cost = stp_draw_frame_cost(&one, &stats, 1.0f, 10.0);
    CHECK(cost.effect_ms[STP_EFFECT_NEAREST] == 4.0 && cost.effect_ms[STP_EFFECT_LAYERS] == 0.0);
}

/// Effects that nobody asks for are told from those that are left out for lack of time.
void test_frame_effects_tell_what_is_unwanted(test_state* test)
{
    enum { GLASS = 1u << STP_EFFECT_LAYERS | 1u << STP_EFFECT_NEAREST };
    const stp_draw_stats stats = {.layers = 1};
    const stp_draw_style whole = {.ambient_occlusion = 0.05f, .supersample = 2},
                         plain = {.supersample = 1},
                         pattern = {.transparency = STP_TRANSPARENCY_PATTERN},
                         dome = {.ambient_occlusion = 0.05f, .supersample = 2, .eye_dome = 1.0f};
    for (uint32_t bits = 0; bits < 16; ++bits) {
        stp_draw_style less = stp_draw_style_without(&whole, bits);
        CHECK_EQUAL(0, stp_draw_frame_cost(&less, &stats, 1.0f, 9.0).unwanted);
        less = stp_draw_style_without(&plain, bits);
        CHECK_EQUAL(3, stp_draw_frame_cost(&less, &stats, 1.0f, 9.0).unwanted);
        less = stp_draw_style_without(&pattern, bits);
        CHECK_EQUAL(3 | GLASS, stp_draw_frame_cost(&less, &stats, 1.0f, 9.0).unwanted);
        less = stp_draw_style_without(&dome, bits); // occlusion is free beside eye-dome lighting
        CHECK_EQUAL(1, stp_draw_frame_cost(&less, &stats, 1.0f, 9.0).unwanted);
    }
}
