// Adds a sample's picture to the sums.
#include "interface.h"
#include "lib_srgb.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba8, binding = IMAGE_PICTURE) uniform readonly image2D picture;
layout(rgba32f, binding = IMAGE_SUMS) uniform image2D sums;
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    pixel.x += int(view.picture_x);
    vec4 color = imageLoad(picture, pixel);
    vec4 sum = color.a > 0.0 ? vec4(to_linear(color.rgb) * color.a, color.a) : vec4(0.0);
    if (view.sample_number > 0u) {
        sum += imageLoad(sums, pixel);
    }
    imageStore(sums, pixel, sum);
}
