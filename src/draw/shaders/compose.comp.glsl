// Composites the layers over the picture.
#include "interface.h"
#include "lib_srgb.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba8, binding = IMAGE_PICTURE) uniform image2D picture;
layout(rgba32f, binding = IMAGE_LIGHT) uniform readonly image2D light;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered, layered; };

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    vec4 layers = imageLoad(light, pixel);
    if (layers.a >= 1.0) {
        return;
    }
    ivec2 place = pixel + ivec2(view.picture_x, 0);
    vec4 behind = imageLoad(picture, place);
    float clear = layers.a * behind.a, coverage = 1.0 - layers.a + clear;
    vec3 color = (layers.rgb + clear * to_linear(behind.rgb)) / coverage;
    imageStore(picture, place, vec4(encode(color), coverage));
    if (behind.a <= 0.0 && view.counts > 0u) {
        atomicAdd(covered, 1u);
    }
}
