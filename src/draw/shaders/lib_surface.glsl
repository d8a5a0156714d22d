// Surface of an id: same as src/draw/cpu/shade_surfaces.c and shade_mesh.c.
#include "lib_normal_map.glsl"
#include "lib_chunk.glsl"
#include "lib_coverage.glsl"
#include "lib_glass.glsl"

layout(std430, binding = BINDING_LOOKUP) readonly buffer Lookup { uint id_starts[ID_TABLE + 2]; uint first_ids[]; };
layout(std430, binding = BINDING_LIGHT_MATERIALS) readonly buffer LightMaterials { light_material_block light_materials[]; };

struct surface {
    vec3 color, normal; // linear; scene space, of any length
    float apart;        // 1 less the length of the mean of the normals that it stands for
    surface_light light;
#ifdef LAYER
    float opacity;
#endif
};

uint find_item(uint id)
{
    uint low = id_starts[id >> view.id_shift], high = id_starts[(id >> view.id_shift) + 1u] + 1u;
    while (high - low > 1u) {
        uint middle = low + (high - low) / 2u;
        if (first_ids[middle] <= id) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

surface_light known_light(uint material)
{
    return surface_light(light_materials[material].surface, light_materials[material].emissive);
}

// Mean normal of the surface that a splat stands for (base/splats/light_normal.h), of length 0 to 1.
// `code`: that of the splat's own normal; bytes add modulo 256.
vec3 light_normal(int code, uint lights, uint index)
{
    int told = lights != NO_ADDRESS ? int(fetch(lights + index)) : 0;
    vec2 turned = vec2(float(bitfieldExtract(code + told, 0, 8)),
                       float(bitfieldExtract((code >> 8) + (told >> 8), 0, 8)));
    return unit(decode_octahedral(turned, 127.0)) * (1.0 - float(told >> 16) * (1.0 / 255.0));
}

surface find_splat(const item_block item, uint index)
{
    chunk_block chunk = find_chunk(item, index);
    uint local = index - chunk.begin, materials_at = chunk.address + 2u * (chunk.end - chunk.begin);
    int code = int(fetch(chunk.address + 2u * local + 1u));
    surface s;
    s.color = to_linear(unpackUnorm4x8(fetch(item.colors + index)).rgb);
    vec3 mean = light_normal(code >> 16, item.lights, index);
    if (index < item.low_count) {
        vec3 low = to_linear(unpackUnorm4x8(fetch(item.low_colors + index)).rgb);
        s.color = low + (s.color - low) * item.blend;
        vec3 low_mean = light_normal(code >> 16, item.low_lights, index);
        mean = low_mean + (mean - low_mean) * item.blend;
    }
    s.apart = 1.0 - min(length(mean), 1.0);
    s.normal = to_scene(item, s.apart < 1.0 ? mean : light_normal(code >> 16, NO_ADDRESS, index));
    s.light = known_light(fetch(materials_at + local / 4u) >> (8u * (local & 3u)) & 255u);
#ifdef LAYER
    s.opacity = glass_opacity(coverage_share(fetch(item.colors + index) >> 24));
    if (index < item.low_count) {
        float low = glass_opacity(coverage_share(fetch(item.low_colors + index) >> 24));
        s.opacity = low + (s.opacity - low) * item.blend;
    }
    s.opacity *= (item.flags & ITEM_GHOST) != 0u ? view.ghost : 1.0;
#endif
    return s;
}

surface find_point(const item_block item, uint index)
{
    chunk_block chunk = find_chunk(item, index);
    uint local = index - chunk.begin, count = chunk.end - chunk.begin;
    uint colors = chunk.address + 3u * count;
    uint normals = colors + ((item.flags & ITEM_HAS_COLORS) != 0u ? count : 0u);
    bool lit = (item.flags & ITEM_HAS_NORMALS) != 0u;
    surface s;
    s.color = materials[item.material].base_color.rgb;
    if ((item.flags & ITEM_HAS_COLORS) != 0u) {
        s.color *= to_linear(unpackUnorm4x8(fetch(colors + local)).rgb);
    }
    s.normal = vec3(0.0);
    s.apart = 0.0;
    if (lit) {
        int code = int(fetch(normals + local));
        s.normal = to_scene(item, decode_octahedral(vec2(float(bitfieldExtract(code, 0, 16)),
                                                         float(bitfieldExtract(code, 16, 16))), 32767.0));
    }
    s.light = known_light(uint(SHADINGS) + item.material);
    s.light.emissive.w = lit ? s.light.emissive.w : 1.0;
#ifdef LAYER
    s.opacity = 1.0;
#endif
    return s;
}

// Finds the cluster of a mesh's triangle.
uint find_cluster(const item_block item, uint index)
{
    uint low = 0u, high = item.cluster_count;
    while (high - low > 1u) {
        uint middle = low + (high - low) / 2u;
        if (fetch(item.address + uint(CLUSTER_WORDS) * middle + CLUSTER_FIRST_TRIANGLE) <= index) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return item.address + uint(CLUSTER_WORDS) * low;
}

// Barycentric coordinates of a pixel.
vec3 find_weights(const item_block item, const vec3 position[3], vec2 pixel)
{
    vec3 corner[3];
    for (int k = 0; k < 3; ++k) {
        vec4 p = vec4(position[k] - item.offset.xyz, 1.0);
        float w = dot(item.rows[3], p);
        // relative to the pixel, to limit rounding errors
        corner[k] = vec3(vec2(dot(item.rows[0], p), dot(item.rows[1], p)) - pixel * w, w);
    }
    vec3 weight = vec3(corner[1].x * corner[2].y - corner[2].x * corner[1].y,
                       corner[2].x * corner[0].y - corner[0].x * corner[2].y,
                       corner[0].x * corner[1].y - corner[1].x * corner[0].y);
    float turned = dot(weight, vec3(corner[0].z, corner[1].z, corner[2].z));
    weight = max(turned < 0.0 ? -weight : weight, vec3(0.0));
    float sum = weight.x + weight.y + weight.z;
    return sum > 0.0 ? weight / sum : vec3(1.0, 0.0, 0.0);
}

vec3 find_normal(const item_block item, const triangle_place t, const vec3 position[3], vec3 weight)
{
    vec3 flat_normal = unit(to_scene(item, unit(cross(position[1] - position[0], position[2] - position[0]))));
    if (t.lighting == TRIANGLE_PLAIN) {
        return flat_normal;
    }
    vec3 first = unit(to_scene(item, corner_normal(t, t.corner.x)));
    if (t.lighting == TRIANGLE_FACE) {
        return first;
    }
    vec3 between = weight.x * first + weight.y * unit(to_scene(item, corner_normal(t, t.corner.y))) +
                   weight.z * unit(to_scene(item, corner_normal(t, t.corner.z)));
    return dot(between, between) > 1e-6 ? between : flat_normal;
}

surface find_triangle_surface(const item_block item, uint index, ivec2 pixel, float nearness)
{
    uint cluster = find_cluster(item, index);
    triangle_place t = find_triangle(item.address, cluster, index - fetch(cluster + CLUSTER_FIRST_TRIANGLE));
    vec3 position[3] = vec3[3](corner_position(t, t.corner.x), corner_position(t, t.corner.y),
                               corner_position(t, t.corner.z));
    vec3 weight = find_weights(item, position, vec2(pixel) + 0.5);
    surface s;
    s.normal = find_normal(item, t, position, weight);
    s.apart = 0.0;
    s.color = materials[item.material].base_color.rgb;
    s.light = known_light(uint(SHADINGS) + item.material);
    float depth = view.parallel != 0u ? 1.0 : view.nearness_scale / nearness;
    float size = depth * item.footprint;
    float opacity = materials[item.material].base_color.a;
    if ((item.flags & ITEM_HAS_COLORS) != 0u) {
        vec4 color = weight.x * corner_color(t, t.corner.x) + weight.y * corner_color(t, t.corner.y) +
                     weight.z * corner_color(t, t.corner.z);
        s.color *= color.rgb;
        opacity *= color.a;
    }
#ifdef TEXTURES
    for (uint n = 0u; n < 4u; ++n) { // an array of them seems to be read wrongly by an NVIDIA driver
        uint map = n == 0u ? item.base_color : n == 1u ? item.metallic_roughness : item.emissive;
        map = n == 3u ? item.normal_map : map;
        if (map == NO_ADDRESS) {
            continue;
        }
        vec4 texel = sample_texture(map, find_uv(t, item.material, n, weight),
                                    find_density(t, item.material, n, map) * size);
        if (n == 0u) {
            s.color *= texel.rgb;
            opacity *= texel.a;
        } else if (n == 1u) {
            vec4 numbers = materials[item.material].numbers;
            s.light = make_light(numbers.x * texel.z, numbers.y * texel.y, s.light.emissive);
        } else if (n == 3u) {
            s.normal = map_normal(item, t, position, unit(s.normal), texel.rgb, pixel);
        } else {
            s.light.emissive.rgb *= texel.rgb;
        }
    }
#endif
#ifdef LAYER
    s.opacity = opacity;
#endif
    return s;
}

surface find_surface(const item_block item, uint id, ivec2 pixel, float nearness)
{
    uint index = id - item.first_id;
    if (item.kind == KIND_SPLATS) {
        return find_splat(item, index);
    }
    return item.kind == KIND_MESH ? find_triangle_surface(item, index, pixel, nearness) : find_point(item, index);
}
