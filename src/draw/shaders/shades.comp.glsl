// Shading of each pixel by its neighbours: eye-dome lighting (a factor) and ambient occlusion (a
// sum).
#include "lib_effect.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(binding = UNIT_BLOCKS) uniform sampler2D blocks;
layout(rg32f, binding = IMAGE_PLANE) uniform writeonly image2D shades;

// Rise of one neighbour of a pair, less the fall of the other: on a plane they cancel.
float rise_above(float a, float b)
{
    return clamp(a - 0.75 * max(-b, 0.0), 0.0, 40.0);
}

float add_rise(float center, float gain, ivec2 pixel, ivec2 step, float inverse)
{
    float one = read_near(pixel + step), other = read_near(pixel - step);
    float a = (one - center) * gain * inverse, b = (other - center) * gain * inverse;
    float known_a = one < 0.0 ? 0.0 : a, known_b = other < 0.0 ? 0.0 : b;
    a = one < 0.0 ? -known_b : a; // planes are extrapolated beyond the border
    b = other < 0.0 ? -known_a : b;
    return rise_above(a, b) + rise_above(b, a);
}

float eye_dome(float center, float gain, ivec2 pixel)
{
    const ivec2 ring[4] = ivec2[4](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1));
    int step = int(effects.light_step);
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) { // two scales
        int reach = i < 4 ? step : 2 * step;
        ivec2 way = ring[i & 3];
        float length = way.x != 0 && way.y != 0 ? 1.41421356 : 1.0;
        sum += add_rise(center, gain, pixel, way * reach, 1.0 / (length * float(reach)));
    }
    float y = sum * effects.numbers.z;
    return 1.0 / (1.0 + y * (1.0 + 0.5 * y));
}

// Upsamples the blocks to pixels by interpolation.
float read_blocks(ivec2 pixel)
{
    if (!is_inside(pixel)) {
        return -1.0;
    }
    ivec2 maximum = (ivec2(view.size.xy) + EFFECT_BLOCK - 1) / EFFECT_BLOCK - 1;
    vec2 at = clamp((vec2(pixel) + 0.5) / float(EFFECT_BLOCK) - 0.5, vec2(0.0), vec2(maximum));
    ivec2 first = ivec2(at), second = min(first + 1, maximum);
    vec2 share = at - vec2(first);
    float above = mix(texelFetch(blocks, first, 0).r, texelFetch(blocks, ivec2(second.x, first.y), 0).r, share.x);
    float below = mix(texelFetch(blocks, ivec2(first.x, second.y), 0).r, texelFetch(blocks, second, 0).r, share.x);
    return mix(above, below, share.y);
}

float occlusion(float center, float gain, ivec2 pixel)
{
    float sum = 0.0;
    for (uint i = 0u; i < effects.pair_count; ++i) {
        vec4 place = effects.pairs[2u * i], numbers = effects.pairs[2u * i + 1u];
        ivec2 step = ivec2(place.xy);
        float one = place.z > 0.0 ? read_blocks(pixel + step) : read_near(pixel + step);
        float other = place.z > 0.0 ? read_blocks(pixel - step) : read_near(pixel - step);
        float a = (one - center) * gain, b = (other - center) * gain, fall = -2.0 / numbers.z;
        float in_reach = clamp(2.0 - a * numbers.z, 0.0, 1.0) * clamp(2.0 - b * numbers.z, 0.0, 1.0);
        float both = max(a, fall) + max(b, fall);
        sum += clamp(both * 0.5 * numbers.x - numbers.y, 0.0, 1.0) * in_reach;
    }
    return sum;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(pixel)) {
        return;
    }
    float center = read_near(pixel), gain = find_gain(center);
    float factor = effects.numbers.z > 0.0 ? eye_dome(center, gain, pixel) : 1.0;
    imageStore(shades, pixel, vec4(factor, occlusion(center, gain, pixel), 0.0, 0.0));
}
