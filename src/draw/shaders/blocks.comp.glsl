// Computes the minimum nearness of the pixels of each block.
#include "interface.h"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(binding = UNIT_FROM) uniform sampler2D from;
layout(r32f, binding = IMAGE_PLANE) uniform writeonly image2D plane;
layout(location = 0) uniform int from_row;

void main()
{
    ivec2 block = ivec2(gl_GlobalInvocationID.xy), size = ivec2(view.size.xy);
    ivec2 first = block * EFFECT_BLOCK, end = min(first + EFFECT_BLOCK, size);
    if (any(greaterThanEqual(first, size))) {
        return;
    }
    float minimum = texelFetch(from, first + ivec2(0, from_row), 0).r;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            minimum = min(minimum, texelFetch(from, ivec2(x, y + from_row), 0).r);
        }
    }
    imageStore(plane, block, vec4(minimum, 0.0, 0.0, 0.0));
}
