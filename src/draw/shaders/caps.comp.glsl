// Draws section caps into a shaded picture and its depths, where they are nearest.
#include "interface.h"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(binding = UNIT_NEARNESS) uniform sampler2D cap_nearness;
layout(binding = UNIT_FROM) uniform sampler2D cap_pixels;
layout(rgba8, binding = IMAGE_PICTURE) uniform writeonly image2D picture;
layout(r32f, binding = IMAGE_DEPTH) uniform image2D depths;
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    ivec2 place = pixel + ivec2(0, view.depth_y);
    float near = texelFetch(cap_nearness, pixel, 0).r, depth = imageLoad(depths, place).r;
    if (near > depth) {
        imageStore(depths, place, vec4(near, 0.0, 0.0, 0.0));
        imageStore(picture, pixel + ivec2(view.picture_x, 0), texelFetch(cap_pixels, pixel, 0));
        if (!(depth > 0.0)) {
            atomicAdd(covered, view.counts);
        }
    }
}
