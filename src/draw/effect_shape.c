// SPDX-License-Identifier: MIT
#include "draw/effect_shape.h"

#include "base/math/math.h"

#include <assert.h>

enum { DIRECTIONS = 6, CLOSE_LIMIT = 4, REACH_MAX = 4096 };

static int32_t nearest_whole(float value)
{
    return (int32_t)floorf(value + 0.5f);
}

/// A ring of pairs; alternate rings are rotated by half a step.
static void add_ring(stp_effect_shape* shape, float reach, float whole, bool turned, bool far)
{
    static const float cosine[2 * DIRECTIONS + 6] = {
        1.0f,  0.965925826f,  0.866025404f,  0.707106781f,  0.5f,          0.258819045f,
        0.0f,  -0.258819045f, -0.5f,         -0.707106781f, -0.866025404f, -0.965925826f,
        -1.0f, -0.965925826f, -0.866025404f, -0.707106781f, -0.5f,         -0.258819045f};
    assert(shape->pair_count + DIRECTIONS <= STP_EFFECT_PAIRS);
    assert(reach > 0.0f && reach <= whole && "rings lie within the radius");
    float rough = 0.35f * (float)shape->close; // remaining depth steps between disks, in pixels
    for (int i = 0; i < DIRECTIONS; ++i) {
        int angle = 2 * i + (turned ? 1 : 0); // in twelfths of half a circle
        float x = cosine[angle], y = -cosine[angle + 6];
        stp_effect_pair pair = {
            .x = nearest_whole(x * reach), .y = nearest_whole(y * reach), .far = far};
        float square = (float)pair.x * (float)pair.x + (float)pair.y * (float)pair.y;
        if (square > 0.0f) {
            float distance = sqrtf(square);
            pair.numbers[0] = 1.0f / distance;
            pair.numbers[1] = 0.05f + rough / distance;
            pair.numbers[2] = 1.0f / whole;
            shape->pairs[shape->pair_count++] = pair;
        }
    }
}

/// Sample pattern of occlusion: near pixels individually, farther ones in blocks.
static void choose_pairs(stp_effect_shape* shape, float reach)
{
    reach = stp_clamp(reach, 2.0f, (float)REACH_MAX);
    float maximum = (float)STP_EFFECT_NEAR_REACH, near = reach < maximum ? reach : maximum;
    add_ring(shape, 0.25f * near, reach, false, false);
    add_ring(shape, 0.5f * near, reach, true, false);
    add_ring(shape, near, reach, false, false);
    if (reach > maximum) {
        add_ring(shape, 0.5f * (maximum + reach), reach, true, true);
        add_ring(shape, reach, reach, false, true);
    }
}

#ifndef NDEBUG
static bool far_pairs_are_last(const stp_effect_shape* shape)
{
    for (uint32_t i = 1; i < shape->pair_count; ++i) {
        if (shape->pairs[i - 1].far && !shape->pairs[i].far) {
            return false;
        }
    }
    return true;
}
#endif

stp_effect_shape stp_effect_shape_make(const stp_draw_style* style, uint32_t height,
                                       float splat_size)
{
    stp_effect_shape shape = {.close = 0};
    if (splat_size > 0.0f) {
        shape.close = nearest_whole(stp_clamp(0.5f * splat_size, 1.0f, (float)CLOSE_LIMIT));
    }
    shape.light_step = shape.close > 2 ? 2 : 1; // wider spacing would give thin objects ghosts
    if (style->eye_dome > 0.0f) {
        shape.light = stp_min(style->eye_dome, STP_EYE_DOME_MAX) * (STP_EYE_DOME_GAIN / 16.0f);
    }
    if (style->ambient_occlusion > 0.0f) {
        choose_pairs(&shape, style->ambient_occlusion * (float)height);
        shape.far = shape.pair_count > 0 && shape.pairs[shape.pair_count - 1].far;
    }
    assert(shape.close >= 0 && shape.close <= CLOSE_LIMIT);
    assert(far_pairs_are_last(&shape) && "the last pair tells whether any is far");
    return shape;
}
