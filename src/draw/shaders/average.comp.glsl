// Computes the mean of the summed samples.
#include "interface.h"
#include "lib_srgb.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba8, binding = IMAGE_PICTURE) uniform writeonly image2D picture;
layout(rgba32f, binding = IMAGE_SUMS) uniform readonly image2D sums;
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    pixel.x += int(view.picture_x);
    vec4 sum = imageLoad(sums, pixel);
    float coverage = sum.a / float(view.sample_count);
    vec3 color = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
    if (view.background.w > 0.0) {
        color = color * coverage + view.background.rgb * (1.0 - coverage);
        imageStore(picture, pixel, vec4(encode(color), 1.0));
    } else {
        imageStore(picture, pixel, coverage > 0.0 ? vec4(encode(color), coverage) : vec4(0.0));
    }
    if (sum.a > 0.0) {
        atomicAdd(covered, 1u);
    }
}
