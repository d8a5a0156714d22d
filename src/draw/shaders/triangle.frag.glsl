// A pixel of a triangle; of a cut-out or transparent one (KEEP) where its material says so, as src/draw/cpu/mesh.c.
#ifdef KEEP
#include "lib_hash.glsl"
#include "lib_texture.glsl"
#endif

layout(location = 0) out uint id;

flat in uint triangle_id;
#ifdef KEEP
flat in uvec2 triangle_of;
in vec2 weight;
in vec3 place;

bool is_there(ivec2 pixel)
{
    record_block record = records[triangle_of.x];
    item_block item = items[record.item];
    material_block material = materials[item.material];
    if (item.sections != 0u && is_cut(item, place)) {
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
    return masked ? own >= cutoff : own >= 1.0 || own > noise(seed, pixel);
}
#endif

void main()
{
#ifdef KEEP
    if (!is_there(ivec2(gl_FragCoord.xy))) {
        discard;
    }
#endif
    id = triangle_id;
}
