// SPDX-License-Identifier: MIT
#include "draw/frame_effects.h"

#include <assert.h>

void stp_draw_split_effects(const stp_draw_style* style, const stp_draw_stats* stats,
                            double milliseconds, double effect_ms[STP_EFFECT_COUNT])
{
    bool occluded = style->ambient_occlusion > 0.0f && !(style->eye_dome > 0.0f);
    bool layered = style->transparency == STP_TRANSPARENCY_LAYERS && stats->layers > 0;
    double side = style->supersample > 1 ? (double)style->supersample : 1.0, all = side * side;
    double occlusion = occluded ? stp_clampd(stats->effect_ms, 0.0, milliseconds) : 0.0;
    double sample = (milliseconds - occlusion) / all;
    effect_ms[STP_EFFECT_OCCLUSION] = occlusion;
    effect_ms[STP_EFFECT_ANTIALIASING] = (all - 1.0) * sample;
    effect_ms[STP_EFFECT_LAYERS] = layered ? stp_clampd(stats->layer_ms / all, 0.0, sample) : 0.0;
}

stp_frame_cost stp_draw_frame_cost(const stp_draw_style* style, const stp_draw_stats* stats,
                                   float splat_size, double milliseconds)
{
    stp_frame_cost cost = {.milliseconds = milliseconds,
                           .splats = stats->listed_splats,
                           .fragments = stats->fragments,
                           .triangles = stats->listed_triangles,
                           .covered_pixels = stats->covered_pixels,
                           .draw_calls = stats->draw_calls,
                           .splat_size = splat_size};
    stp_draw_split_effects(style, stats, milliseconds, cost.effect_ms);
    return cost;
}

stp_draw_style stp_draw_style_without(const stp_draw_style* style, uint32_t left_out)
{
    stp_draw_style less = *style;
    assert(left_out >> STP_EFFECT_COUNT == 0 && "bits of known effects");
    if ((left_out >> STP_EFFECT_OCCLUSION & 1u) != 0) {
        less.ambient_occlusion = 0.0f;
    }
    if ((left_out >> STP_EFFECT_ANTIALIASING & 1u) != 0) {
        less.supersample = 1;
    }
    if ((left_out >> STP_EFFECT_LAYERS & 1u) != 0 &&
        style->transparency == STP_TRANSPARENCY_LAYERS) {
        less.transparency = STP_TRANSPARENCY_NEAREST;
    }
    return less;
}
