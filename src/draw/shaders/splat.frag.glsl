// A pixel of a disk drawn as a point.
#extension GL_ARB_conservative_depth : enable
#include "lib_fragment.glsl"
#include "lib_layer.glsl"

layout(depth_less) out float gl_FragDepth;
layout(location = 0) out uint id;

flat in vec4 center;
flat in vec4 conic;
flat in vec4 conic2;
flat in vec2 depths;
flat in vec4 clip;
flat in uvec3 hashed;

void main()
{
    float nearness;
    if (!has_pixel(center, conic, conic2, depths, clip, hashed, ivec2(gl_FragCoord.xy), nearness)) {
        discard;
    }
#ifdef LAYER
    if (!is_splat_between(ivec2(gl_FragCoord.xy), nearness, hashed.x)) {
        discard;
    }
#endif
    gl_FragDepth = nearness;
    id = hashed.x;
}
