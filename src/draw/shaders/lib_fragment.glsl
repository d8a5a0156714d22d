// A pixel of a disk: inside if the ray through its centre hits the plane within the radius.
#include "lib_holes.glsl"

#ifdef SQUARE
// A pixel of a square: from conic.xy to conic.zw.
bool has_pixel(vec4 center, vec4 conic, vec4 conic2, vec2 depths, vec4 clip, uvec3 hashed, ivec2 pixel, out float nearness)
{
    ivec2 place = pixel - ivec2(floor(center.xy));
    precise vec2 at = (vec2(pixel) + 0.5) - center.xy;
    precise float across = clip.x * at.x + clip.y * at.y;
    nearness = center.z;
    return all(greaterThanEqual(vec2(pixel), conic.xy)) && all(lessThanEqual(vec2(pixel), conic.zw)) && across >= clip.z &&
           across <= clip.w && is_drawn(hashed, pixel, place);
}
#else
bool has_pixel(vec4 center, vec4 conic, vec4 conic2, vec2 depths, vec4 clip, uvec3 hashed, ivec2 pixel, out float nearness)
{
    ivec2 place = pixel - ivec2(floor(center.xy));
    precise vec2 at = (vec2(pixel) + 0.5) - center.xy;
    precise float value = at.x * ((conic.x * at.x + conic.y * at.y) + conic.w) + at.y * (conic.z * at.y + conic2.x);
    precise float change = clamp(conic2.z * at.x + conic2.w * at.y, -center.w, center.w);
    precise float near = (center.z + change) - min(value, conic2.y) * depths.x;
    nearness = min(max(near, 1e-30), depths.y);
    precise float across = clip.x * at.x + clip.y * at.y;
    return value <= conic2.y && across >= clip.z && across <= clip.w && is_drawn(hashed, pixel, place);
}
#endif
