// Builds the depth pyramid: minimum nearness per block in the visibility buffer, for blocks of 8 x
// 8 pixels, and blocks of blocks up to the 64 x 64 pixels of a group (Greene, Kass, Miller 1993).
#include "interface.h"
#include "lib_pyramid.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(binding = UNIT_NEARNESS) uniform sampler2D visible_nearness;
layout(std430, binding = BINDING_PYRAMID) writeonly buffer Pyramid { float nearest[]; };

shared float blocks[GROUP_SIDE * GROUP_SIDE];

float find_block(ivec2 block, ivec2 size)
{
    ivec2 first = block * PYRAMID_BLOCK, end = min(first + PYRAMID_BLOCK, size);
    float minimum = 1e30; // nothing is visible outside the picture
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            minimum = min(minimum, texelFetch(visible_nearness, ivec2(x, y), 0).r);
        }
    }
    return minimum;
}

void main()
{
    ivec2 size = ivec2(view.size.xy), block = ivec2(gl_GlobalInvocationID.xy), local = ivec2(gl_LocalInvocationID.xy);
    int at = GROUP_SIDE * local.y + local.x;
    float minimum = find_block(block, size);
    blocks[at] = minimum;
    for (int level = 0; level < PYRAMID_LEVELS; ++level) {
        int step = 1 << level;
        ivec2 count = count_blocks(size, level), place = block >> level;
        bool mine = (local & (step - 1)) == ivec2(0);
        barrier();
        if (mine && level > 0) {
            int half_step = step / 2;
            minimum = min(min(blocks[at], blocks[at + half_step]),
                        min(blocks[at + GROUP_SIDE * half_step], blocks[at + GROUP_SIDE * half_step + half_step]));
        }
        barrier();
        if (mine) {
            blocks[at] = minimum;
            if (all(lessThan(place, count))) {
                nearest[find_level(size, level) + place.y * count.x + place.x] = minimum;
            }
        }
    }
}
