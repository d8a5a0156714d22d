// Blurs occlusion along columns, and darkens the picture by all shading effects.
#include "lib_effect.glsl"
#include "lib_srgb.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(binding = UNIT_FROM) uniform sampler2D from;
layout(binding = UNIT_BLOCKS) uniform sampler2D covered_depths; // before closing gaps
layout(rgba8, binding = IMAGE_PICTURE) uniform image2D picture;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    float center = read_near(pixel), gain = find_gain(center);
    ivec2 place = pixel + ivec2(view.picture_x, 0);
    if (!is_inside(pixel)) {
        return;
    }
    vec4 color = imageLoad(picture, place);
    vec2 here = texelFetch(from, pixel, 0).rg, sum = vec2(here.y, 1.0);
    for (int k = -2; k <= 2; ++k) {
        ivec2 at = pixel + ivec2(0, k);
        if (k != 0 && is_inside(at)) {
            blur(sum, center, gain, read_near(at), texelFetch(from, at, 0).g, float(abs(k)));
        }
    }
    float factor = here.x;
    if (effects.pair_count > 0u) {
        factor *= max(1.0 - sum.x / sum.y * effects.numbers.w, 0.15);
    }
    if (texelFetch(covered_depths, pixel + ivec2(0, view.depth_y), 0).r > 0.0) {
        imageStore(picture, place, vec4(encode(to_linear(color.rgb) * factor), color.a));
    }
}
