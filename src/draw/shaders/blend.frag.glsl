// A pixel of a disk, added if the disk belongs to the pixel's visible surface (Botsch et al. 2005;
// src/raster/splats_blend.c).
#include "lib_hash.glsl"
#include "lib_blend.glsl"

layout(binding = UNIT_PLANES) uniform sampler2D planes;

layout(location = 0) out vec4 sum; // weighted colour, weight

flat in vec4 center;
flat in vec4 conic;
flat in vec4 conic2;
flat in vec4 color;
flat in vec4 ray;
flat in vec4 clip;
flat in vec2 slope;
flat in uvec3 hashed;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy), place = pixel - ivec2(floor(center.xy));
    vec4 plane = texelFetch(planes, pixel, 0);
    vec2 at = vec2(pixel) + 0.5 - center.xy;
    bool tiny = ray.w > 0.5;
    float value = at.x * (conic.x * at.x + conic.y * at.y + conic.w) + at.y * (conic.z * at.y + conic2.x);
    float across = clip.x * at.x + clip.y * at.y;
    if (plane.w == PLANE_NONE || !(value <= conic2.y) || across < clip.z || across > clip.w) {
        discard;
    }
    float nearness = center.z + clamp(dot(conic2.zw, at), -center.w, center.w);
    float side = find_side(slope, nearness);
    if (abs(nearness - plane.x) > side * BLEND_AWAY * (tiny ? 0.5 : color.w)) {
        discard;
    }
    vec2 direction = (vec2(pixel) - ray.xy) * ray.z;
    if (!tiny && plane.w == PLANE_DISK &&
        is_turned(slope_normal(conic2.zw / side, direction), slope_normal(plane.yz, direction))) {
        discard;
    }
    if (hashed.z < 255u && !has_fragment(hashed.z, hashed.y, place)) {
        discard;
    }
    float weight = blend_weight(tiny ? BLEND_TINY : 1.0 - max(value, 0.0) / conic2.y);
    sum = vec4(weight * color.rgb, weight);
}
