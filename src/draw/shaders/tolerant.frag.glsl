#ifdef INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
#endif
// A pixel of a disk, blended with what was drawn before where both are about as near, in one pass: the depth and blending
// node that Dachsbacher et al. 2003 propose (section 5). Sums are not divided before the end, which is the same.
#include "lib_hash.glsl"
#include "lib_blend.glsl"
#include "lib_tolerant.glsl"

#ifdef INTERLOCK
layout(pixel_interlock_ordered) in;
#endif
layout(early_fragment_tests) in; // there are none: nothing is drawn but the buffer
layout(binding = UNIT_NEARNESS) uniform sampler2D triangles; // how near they are

flat in vec4 center;
flat in vec4 conic;
flat in vec4 conic2;
flat in vec4 color;
flat in vec4 ray;
flat in vec2 slope;
flat in uvec3 hashed;

void blend(uint at, float nearness, float fuzzy, vec4 sum)
{
    float before = pixels[at].nearness;
    if (nearness > before + fuzzy) { // also where there was nothing
        pixels[at].nearness = nearness;
        pixels[at].id = hashed.x;
        pixels[at].sum = sum;
    } else if (nearness > before - fuzzy) {
        pixels[at].sum += sum;
    }
}

bool is_in(ivec2 pixel, float value)
{
    ivec2 place = pixel - ivec2(floor(center.xy));
    return (value <= conic2.y || place == ivec2(0)) &&
           (hashed.z >= 255u || has_fragment(hashed.z, hashed.y, place));
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 at = vec2(pixel) + 0.5 - center.xy;
    bool tiny = ray.w > 0.5;
    float value = at.x * (conic.x * at.x + conic.y * at.y + conic.w) + at.y * (conic.z * at.y + conic2.x);
    float nearness = center.z + clamp(dot(conic2.zw, at), -center.w, center.w);
    float fuzzy = find_side(slope, nearness) * BLEND_AWAY * (tiny ? 0.5 : color.w);
    float weight = blend_weight(tiny ? BLEND_TINY : 1.0 - max(value, 0.0) / conic2.y);
    vec4 sum = vec4(weight * color.rgb, weight);
    bool drawn = !gl_HelperInvocation && all(lessThan(pixel, ivec2(view.size.xy))) && is_in(pixel, value) &&
                 nearness > 0.0 && nearness > texelFetch(triangles, pixel, 0).r;
    uint place = uint(pixel.y) * uint(view.size.x) + uint(pixel.x);
#ifdef INTERLOCK
    beginInvocationInterlockARB();
    if (drawn) {
        blend(place, nearness, fuzzy, sum);
    }
    endInvocationInterlockARB();
#else
    // each gives way to the one that is at its pixel; a thread that waited for its neighbour in here would wait for ever
    for (uint i = 0u; drawn && i < uint(LOCK_TRIES); ++i) {
        if (atomicExchange(pixels[place].lock, 1u) == 0u) {
            blend(place, nearness, fuzzy, sum);
            memoryBarrierBuffer();
            atomicExchange(pixels[place].lock, 0u);
            drawn = false;
        }
    }
#endif
}
