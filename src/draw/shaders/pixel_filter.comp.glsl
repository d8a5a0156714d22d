// The pixel filter of a picture with one sample a pixel (src/draw/cpu/pixel_filter.h), in the same
// integers.
#include "interface.h"
#include "pixel_filter_constants.h"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(binding = UNIT_FROM) uniform sampler2D from;
layout(binding = UNIT_BLOCKS) uniform usampler2D kinds; // 1 where a pixel shows a splat
layout(rgba8, binding = IMAGE_PICTURE) uniform writeonly image2D picture;

ivec2 inside(ivec2 pixel)
{
    return clamp(pixel, ivec2(0), ivec2(view.size.xy) - 1);
}

uint weight_of(ivec2 pixel)
{
    return texelFetch(kinds, inside(pixel), 0).r != 0u ? PIXEL_WEIGHT_SPLAT : PIXEL_WEIGHT_TRIANGLE;
}

// Light times coverage, and coverage.
uvec4 light_of(ivec2 pixel)
{
    uvec4 bytes = uvec4(texelFetch(from, inside(pixel) + ivec2(view.picture_x, 0), 0) * 255.0 + 0.5);
    return uvec4(bytes.rgb * bytes.rgb * bytes.a / 255u, bytes.a * 255u);
}

uvec4 mix_three(uvec4 a, uvec4 b, uvec4 c, uint weight)
{
    uvec4 sides = (a + c + 1u) >> 1u;
    return b - (b * weight >> 16u) + (sides * weight >> 16u);
}

uvec4 across(ivec2 pixel)
{
    return mix_three(light_of(pixel - ivec2(1, 0)), light_of(pixel), light_of(pixel + ivec2(1, 0)), weight_of(pixel));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    uvec4 light = mix_three(across(inside(pixel - ivec2(0, 1))), across(pixel), across(inside(pixel + ivec2(0, 1))), weight_of(pixel));
    vec4 color = vec4(light);
    bool border = light.a > 0u && light.a < PIXEL_COVERED;
    float scale = border ? 65025.0 / color.a : 1.0;
    vec3 bytes = floor(sqrt(min(color.rgb * scale, vec3(65025.0))) + 0.5);
    float alpha = border ? floor(color.a * (1.0 / 255.0) + 0.5) : light.a == 0u ? 0.0 : 255.0;
    imageStore(picture, pixel + ivec2(view.picture_x, 0), vec4(bytes, alpha) / 255.0);
}
