// Shared by passes over the nearness of a picture: src/draw/cpu/effects.c and effects_rows.h.
#include "interface.h"

layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(std140, binding = BINDING_EFFECTS) uniform Effects { effect_block effects; };
layout(binding = UNIT_NEARNESS) uniform sampler2D near_plane;
layout(location = 0) uniform int near_row; // first row of the eye's picture in near_plane

bool is_inside(ivec2 pixel)
{
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(view.size.xy)));
}

// -1 outside the picture.
float read_near(ivec2 pixel)
{
    return is_inside(pixel) ? texelFetch(near_plane, pixel + ivec2(0, near_row), 0).r : -1.0;
}

// A nearness difference times this is a depth difference in pixel sides at that depth.
float find_gain(float nearness)
{
    float gain = effects.numbers.y > 0.0 ? effects.numbers.x : effects.numbers.x / max(nearness, 1e-30);
    return nearness > 0.0 ? gain : 0.0;
}

// A value and the sum of weights, for a mean over pixels of a surface.
void blur(inout vec2 sum, float center, float gain, float neighbour, float value, float distance)
{
    float weight = max(1.0 - abs((neighbour - center) * gain / (4.0 * distance)), 0.0);
    sum += weight * vec2(value, 1.0);
}
