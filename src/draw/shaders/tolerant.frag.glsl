#ifdef INTERLOCK
#extension GL_ARB_fragment_shader_interlock : require
#endif
// A pixel of a disk, blended in one pass with earlier fragments at about the same depth: the
// tolerant depth test proposed by Dachsbacher et al. 2003 (section 5). Sums are divided only at the
// end, which is equivalent.
#include "lib_hash.glsl"
#include "lib_blend.glsl"
#include "lib_tolerant.glsl"

#ifdef INTERLOCK
layout(pixel_interlock_ordered) in;
#endif
layout(early_fragment_tests) in; // no outputs: only the buffer is written
layout(binding = UNIT_NEARNESS) uniform sampler2D triangles; // their nearness

flat in vec4 center;
flat in vec4 conic;
flat in vec4 conic2;
flat in vec4 color;
flat in vec4 ray;
flat in vec4 clip;
flat in vec2 slope;
flat in vec2 depths;
flat in uvec3 hashed;
#ifdef TEXTURED
flat in vec4 axes; // the texture's, see lib_map.glsl
layout(binding = UNIT_SPLAT_TEXTURE) uniform sampler2D splat_texture;
layout(location = 0) uniform uint tiny_weight; // weight of a one-pixel splat
#endif

struct fragment {
    float key;    // nearness for ordering
    float plane;  // nearness of its plane
    float fuzzy;  // tolerance
    uint slopes;  // slopes of the plane, in the pixels' encoding
    vec2 turn;    // slopes of the plane, as floats
    vec2 direction;
    vec4 sum;
};

// Slopes of a pixel's plane, in the word that is also its lock. One-pixel splats have none.
uint pack_slopes(bool tiny, vec2 slopes)
{
    bool known = !any(isnan(slopes)); // NaN could equal TOLERANT_TAKEN
    return tiny || !known ? TOLERANT_TINY : packHalf2x16(clamp(slopes, -60000.0, 60000.0));
}

bool is_alike(const fragment f, float plane, uint slopes)
{
    if (abs(f.plane - plane) > f.fuzzy) {
        return false;
    }
    return f.slopes == TOLERANT_TINY || slopes == TOLERANT_TINY ||
           !is_turned(slope_normal(f.turn, f.direction), slope_normal(unpackHalf2x16(slopes), f.direction));
}

// The front fragment defines the pixel's plane; fragments near the plane are added. @return slopes
// of the pixel's plane
uint blend(uint at, const fragment f, uint slopes)
{
    float before = pixels[at].key;
    bool front = f.key > before; // also for an empty pixel
    bool alike = before > 0.0 && is_alike(f, pixels[at].plane, slopes);
    if (front) {
        pixels[at].key = f.key;
        pixels[at].plane = f.plane;
        pixels[at].id = hashed.x;
    }
    if (alike) {
        pixels[at].sum += f.sum;
    } else if (front) {
        pixels[at].sum = f.sum;
    }
    return front ? f.slopes : slopes;
}

float find_weight(bool tiny, vec2 at, float value)
{
#ifdef TEXTURED
    if (tiny) {
        return float(tiny_weight);
    }
    float depth = 1.0 / (1.0 - 0.5 * dot(vec2(conic.w, conic2.x), at) / conic2.y);
    vec2 place = depth * vec2(dot(axes.xy, at), dot(axes.zw, at));
    return weight_of_opacity(textureLod(splat_texture, 0.5 * place + 0.5, 0.0).r);
#else
    return blend_weight(tiny ? BLEND_TINY : 1.0 - max(value, 0.0) / conic2.y);
#endif
}

bool is_in(ivec2 pixel, vec2 at, float value)
{
    float across = clip.x * at.x + clip.y * at.y;
    ivec2 place = pixel - ivec2(floor(center.xy));
    return value <= conic2.y && across >= clip.z && across <= clip.w &&
           (hashed.z >= 255u || has_fragment(hashed.z, hashed.y, place));
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 at = vec2(pixel) + 0.5 - center.xy;
    bool tiny = ray.w > 0.5;
    float value = at.x * (conic.x * at.x + conic.y * at.y + conic.w) + at.y * (conic.z * at.y + conic2.x);
    fragment f;
    f.plane = center.z + clamp(dot(conic2.zw, at), -center.w, center.w);
    f.key = min(max(f.plane - min(value, conic2.y) * depths.x, 1e-30), depths.y);
    float side = find_side(slope, f.plane);
    f.fuzzy = side * BLEND_AWAY * (tiny ? 0.5 : color.w);
    f.turn = conic2.zw / side;
    f.slopes = pack_slopes(tiny, f.turn);
    f.direction = (vec2(pixel) - ray.xy) * ray.z;
    float weight = find_weight(tiny, at, value);
    f.sum = vec4(weight * color.rgb, weight);
    bool drawn = !gl_HelperInvocation && all(lessThan(pixel, ivec2(view.size.xy))) && is_in(pixel, at, value) &&
                 f.plane + f.fuzzy > texelFetch(triangles, pixel, 0).r; // merging compares keys
    uint place = uint(pixel.y) * uint(view.size.x) + uint(pixel.x);
#ifdef INTERLOCK
    beginInvocationInterlockARB();
    if (drawn) {
        pixels[place].slopes = blend(place, f, pixels[place].slopes);
    }
    endInvocationInterlockARB();
#else
    // a thread that finds its pixel locked tries again; waiting inside for a neighbouring thread
    // would deadlock
    for (uint i = 0u; drawn && i < uint(LOCK_TRIES); ++i) {
        uint slopes = atomicExchange(pixels[place].slopes, TOLERANT_TAKEN);
        if (slopes != TOLERANT_TAKEN) {
            slopes = blend(place, f, slopes);
            memoryBarrierBuffer();
            atomicExchange(pixels[place].slopes, slopes);
            drawn = false;
        }
    }
#endif
}
