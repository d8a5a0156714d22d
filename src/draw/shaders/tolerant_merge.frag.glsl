// Copies the result of one-pass blending: nearness and id into the visibility buffer, and sums for
// shading.
#include "lib_tolerant.glsl"

layout(location = 0) out uint id;
layout(location = 1) out vec4 sum;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint at = uint(pixel.y) * uint(view.size.x) + uint(pixel.x);
    float nearness = pixels[at].key;
    if (!(nearness > 0.0)) {
        discard;
    }
    sum = pixels[at].sum;
    id = pixels[at].id;
    gl_FragDepth = nearness;
}
