// A pixel of a triangle; for cutout and transparent ones (KEEP) with the material's alpha test, as
// in src/draw/cpu/triangle_look.c.
#include "lib_glass.glsl"
#include "lib_layer.glsl"
#include "lib_texture.glsl"

layout(location = 0) out uint id;

flat in uint triangle_id;
#ifdef KEEP
flat in uvec2 triangle_of;
in vec2 weight;
in vec3 place;

#ifdef LAYER
layout(r32ui, binding = IMAGE_OPTICAL) uniform uimage2D optical_depths;
uint depth_of_fragment = 0u; // optical
#endif

// Key of a triangle's alpha thresholds: its facing, and its position along that direction.
uint find_pattern(const item_block item, const triangle_place t)
{
    vec3 a = corner_position(t, t.corner.x) - item.offset.xyz, b = corner_position(t, t.corner.y) - item.offset.xyz;
    vec3 c = corner_position(t, t.corner.z) - item.offset.xyz;
    precise vec3 turned = cross(b - a, c - a), middles = (a + b + c) * (1.0 / 3.0);
    vec3 size = abs(turned);
    uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
    float along = axis == 0u ? turned.x : axis == 1u ? turned.y : turned.z;
    float middle = axis == 0u ? middles.x : axis == 1u ? middles.y : middles.z;
    float cell = floor(clamp(middle * item.glass_cells, -GLASS_CELLS, GLASS_CELLS));
    return find_glass_key(item.seed - view.pattern * 0x9E3779B1u, 2u * axis + (along < 0.0 ? 1u : 0u), int(cell));
}

// Whether a fragment of a blended material is drawn.
bool keeps_alpha(const item_block item, const triangle_place t, float alpha, ivec2 pixel)
{
#ifdef LAYER
    depth_of_fragment = optical_depth(alpha);
    return alpha >= ALPHA_MIN && alpha < ALPHA_OPAQUE_FROM;
#else
    if (alpha >= ALPHA_OPAQUE_FROM || view.glass == GLASS_LAYERS) {
        return alpha >= ALPHA_OPAQUE_FROM;
    }
    return alpha > find_threshold(find_pattern(item, t), pixel, view.pattern);
#endif
}

bool is_there(ivec2 pixel)
{
    record_block record = records[triangle_of.x];
    item_block item = items[record.item];
    material_block material = materials[item.material];
    if (item.sections != 0u && is_beyond_section(item, place)) {
        return false;
    }
    uvec2 seed = uvec2(triangle_id - item.first_id, item.seed);
    if ((item.flags & ITEM_GHOST) != 0u && noise(random_bits(seed, uvec2(view.ghost_seed, 0u)), pixel) >= view.ghost) {
        return false;
    }
    if (uint(material.numbers.w) == ALPHA_OPAQUE) {
        return true;
    }
    triangle_place t = find_triangle(item.address, record.address, triangle_of.y);
    vec3 share = vec3(1.0 - weight.x - weight.y, weight);
    float own = material.base_color.a, cutoff = material.numbers.z;
    if ((item.flags & ITEM_HAS_COLORS) != 0u) {
        own *= share.x * corner_color(t, t.corner.x).a + share.y * corner_color(t, t.corner.y).a +
               share.z * corner_color(t, t.corner.z).a;
    }
    bool masked = uint(material.numbers.w) == ALPHA_MASK;
#ifdef TEXTURES
    if (item.base_color != NO_ADDRESS) {
        float depth = 1.0 / gl_FragCoord.w;
        float footprint = find_density(t, item.material, 0u, item.base_color) * depth * item.footprint;
        vec2 uv = find_uv(t, item.material, 0u, share);
        if (masked) {
            return keeps_cutout(item.base_color, uv, footprint, own, cutoff);
        }
        own *= sample_alpha(item.base_color, uv, footprint);
    }
#endif
    return masked ? own >= cutoff : keeps_alpha(item, t, own, pixel);
}
#endif

void main()
{
#ifdef KEEP
    if (!is_there(ivec2(gl_FragCoord.xy))) {
        discard;
    }
#endif
#ifdef LAYER
    if (!is_between(ivec2(gl_FragCoord.xy), gl_FragCoord.z, triangle_id)) {
        discard;
    }
    if (view.nearest_only != 0u) { // of all fragments between, nearest or not
        imageAtomicAdd(optical_depths, ivec2(gl_FragCoord.xy), depth_of_fragment);
    }
    gl_FragDepth = gl_FragCoord.z;
#endif
    id = triangle_id;
}
