// Maximum or minimum of neighbours along an axis, to close gaps between disks.
#include "interface.h"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };
layout(binding = UNIT_FROM) uniform sampler2D from;
layout(r32f, binding = IMAGE_PLANE) uniform writeonly image2D plane;
layout(location = 0) uniform int from_row;
layout(location = 1) uniform ivec4 window; // axis, reach, and above 0 for the maximum

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = ivec2(view.size.xy);
    if (any(greaterThanEqual(pixel, size))) {
        return;
    }
    float found = texelFetch(from, pixel + ivec2(0, from_row), 0).r;
    for (int k = -window.z; k <= window.z; ++k) {
        // repeating the border changes nothing
        ivec2 at = clamp(pixel + k * window.xy, ivec2(0), size - 1);
        float value = texelFetch(from, at + ivec2(0, from_row), 0).r;
        found = window.w > 0 ? max(found, value) : min(found, value);
    }
    imageStore(plane, pixel, vec4(found, 0.0, 0.0, 0.0));
}
