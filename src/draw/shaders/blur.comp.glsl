// Blurs occlusion along rows, within surfaces.
#include "lib_effect.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(binding = UNIT_FROM) uniform sampler2D from;
layout(rg32f, binding = IMAGE_PLANE) uniform writeonly image2D shades;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!is_inside(pixel)) {
        return;
    }
    vec2 here = texelFetch(from, pixel, 0).rg, sum = vec2(here.y, 1.0);
    float center = read_near(pixel), gain = find_gain(center);
    for (int k = -2; k <= 2; ++k) {
        ivec2 at = pixel + ivec2(k, 0);
        if (k != 0) {
            float value = is_inside(at) ? texelFetch(from, at, 0).g : 0.0;
            blur(sum, center, gain, read_near(at), value, float(abs(k)));
        }
    }
    imageStore(shades, pixel, vec4(here.x, sum.x / sum.y, 0.0, 0.0));
}
