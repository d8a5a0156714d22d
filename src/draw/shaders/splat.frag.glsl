// A pixel of a disk: in where the ray through its middle meets the plane within the radius, or where it holds the centre.
#extension GL_ARB_conservative_depth : enable
#include "lib_hash.glsl"

layout(depth_less) out float gl_FragDepth;
layout(location = 0) out uint id;

flat in vec4 center;
flat in vec4 conic;
flat in vec4 conic2;
flat in vec2 depths;
flat in uvec3 hashed;

void main()
{
    vec2 at = gl_FragCoord.xy - center.xy;
    ivec2 place = ivec2(gl_FragCoord.xy) - ivec2(floor(center.xy));
    float value = at.x * (conic.x * at.x + conic.y * at.y + conic.w) +
                  at.y * (conic.z * at.y + conic2.x);
    if (!(value <= conic2.y) && place != ivec2(0)) {
        discard;
    }
    if (hashed.z < 255u && !has_fragment(hashed.z, hashed.y, place)) {
        discard;
    }
    float change = clamp(dot(conic2.zw, at), -center.w, center.w);
    float nearness = center.z + change - min(value, conic2.y) * depths.x;
    gl_FragDepth = min(max(nearness, 1e-30), depths.y);
    id = hashed.x;
}
