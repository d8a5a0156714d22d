// SPDX-License-Identifier: MIT
#include "draw/frame_effects.h"

#include <assert.h>

static bool is_left_out(uint32_t left_out, stp_budget_effect effect)
{
    return (left_out >> effect & 1u) != 0;
}

/// Effects that a style has, as bits 1 << stp_budget_effect.
static uint32_t list_effects(const stp_draw_style* style)
{
    const uint32_t glass = 1u << STP_EFFECT_LAYERS | 1u << STP_EFFECT_NEAREST;
    return (style->ambient_occlusion > 0.0f ? 1u << STP_EFFECT_OCCLUSION : 0u) |
           (style->supersample > 1 ? 1u << STP_EFFECT_ANTIALIASING : 0u) |
           (style->transparency == STP_TRANSPARENCY_LAYERS ? glass : 0u);
}

/// Effects that are neither drawn nor left out for lack of time, and those that are free.
static uint32_t list_unwanted(const stp_draw_style* style)
{
    uint32_t wanted = list_effects(style) | style->left_out;
    wanted |= is_left_out(style->left_out, STP_EFFECT_LAYERS) ? 1u << STP_EFFECT_NEAREST : 0u;
    wanted &= style->eye_dome > 0.0f ? ~(1u << STP_EFFECT_OCCLUSION) : ~0u;
    return ~wanted & ((1u << STP_EFFECT_COUNT) - 1u);
}

/// Splits the time of transparent surfaces. All layers take a pass each, and one that finds nothing.
/// The nearest layer is an effect if it is drawn for lack of time, not where a style wants it.
static void split_layers(const stp_draw_style* style, uint32_t layers, double milliseconds,
                         double effect_ms[STP_EFFECT_COUNT])
{
    bool all = style->transparency == STP_TRANSPARENCY_LAYERS;
    bool one = style->transparency == STP_TRANSPARENCY_NEAREST &&
               is_left_out(style->left_out, STP_EFFECT_LAYERS);
    double first = milliseconds / ((double)layers + 1.0);
    effect_ms[STP_EFFECT_LAYERS] = all ? milliseconds - first : 0.0;
    effect_ms[STP_EFFECT_NEAREST] = all ? first : one ? milliseconds : 0.0;
}

static void split(const stp_draw_style* style, const stp_draw_stats* stats, double milliseconds,
                  double effect_ms[STP_EFFECT_COUNT])
{
    bool occluded = style->ambient_occlusion > 0.0f && !(style->eye_dome > 0.0f);
    double side = style->supersample > 1 ? (double)style->supersample : 1.0, all = side * side;
    double occlusion = occluded ? stp_clampd(stats->effect_ms, 0.0, milliseconds) : 0.0;
    double sample = (milliseconds - occlusion) / all;
    double layers = stats->layers > 0 ? stp_clampd(stats->layer_ms / all, 0.0, sample) : 0.0;
    effect_ms[STP_EFFECT_OCCLUSION] = occlusion;
    effect_ms[STP_EFFECT_ANTIALIASING] = (all - 1.0) * sample;
    split_layers(style, stats->layers, layers, effect_ms);
}

stp_frame_cost stp_draw_frame_cost(const stp_draw_style* style, const stp_draw_stats* stats,
                                   float splat_size, double milliseconds)
{
    stp_frame_cost cost = {.milliseconds = milliseconds,
                           .splats = stats->listed_splats,
                           .fragments = stats->fragments,
                           .triangles = stats->triangles,
                           .listed_triangles = stats->listed_triangles,
                           .covered_pixels = stats->covered_pixels,
                           .draw_calls = stats->draw_calls,
                           .splat_size = splat_size,
                           .resolution = stp_draw_resolution(style),
                           .unwanted = list_unwanted(style)};
    split(style, stats, milliseconds, cost.effect_ms);
    return cost;
}

stp_draw_style stp_draw_style_without(const stp_draw_style* style, uint32_t left_out)
{
    stp_draw_style less = *style;
    assert(left_out >> STP_EFFECT_COUNT == 0 && "bits of known effects");
    bool layered = style->transparency == STP_TRANSPARENCY_LAYERS;
    less.left_out = left_out & list_effects(style);
    if (is_left_out(left_out, STP_EFFECT_OCCLUSION)) {
        less.ambient_occlusion = 0.0f;
    }
    if (is_left_out(left_out, STP_EFFECT_ANTIALIASING)) {
        less.supersample = 1;
    }
    if (layered && is_left_out(left_out, STP_EFFECT_LAYERS)) {
        less.transparency = is_left_out(left_out, STP_EFFECT_NEAREST) ? STP_TRANSPARENCY_PATTERN
                                                                      : STP_TRANSPARENCY_NEAREST;
    }
    return less;
}
