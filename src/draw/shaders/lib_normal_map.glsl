// Normal maps, the same as src/raster/normal_map.c and src/draw/cpu/shade_mesh.c.
#include "lib_texture.glsl"
#include "lib_light.glsl"

vec3 to_scene(const item_block item, vec3 n)
{
    return vec3(dot(item.normal[0].xyz, n), dot(item.normal[1].xyz, n), dot(item.normal[2].xyz, n));
}

// A unit normal of the scene, turned by a texel. Placements keep angles, so what turns normals turns
// tangents, too.
vec3 map_normal(const item_block item, const triangle_place t, const vec3 position[3], vec3 normal, vec3 texel)
{
    vec4 first = materials[item.material].uses[6], second = materials[item.material].uses[7];
    uint set = uint(first.w);
    if (!has_texcoords(t, set)) {
        return normal;
    }
    vec2 a = corner_texcoord(t, set, t.corner.x);
    vec2 b = corner_texcoord(t, set, t.corner.y) - a, c = corner_texcoord(t, set, t.corner.z) - a;
    vec2 ab = vec2(dot(first.xy, b), dot(second.xy, b)), ac = vec2(dot(first.xy, c), dot(second.xy, c));
    float turn = ab.x * ac.y - ac.x * ab.y, turned = turn < 0.0 ? -1.0 : 1.0;
    vec3 p = position[1] - position[0], q = position[2] - position[0];
    vec3 right = turned * (ac.y * p - ab.y * q), up = turned * (ac.x * p - ab.x * q);
    if (!(abs(turn) > 0.0 && dot(right, right) > 0.0 && dot(up, up) > 0.0)) {
        return normal;
    }
    right = unit(to_scene(item, right));
    vec3 slope = vec3((2.0 * texel.xy - 1.0) * second.w, max(2.0 * texel.z - 1.0, 0.0));
    right = unit(right - normal * dot(right, normal));
    vec3 above = cross(normal, right);
    slope.y = dot(above, to_scene(item, up)) < 0.0 ? -slope.y : slope.y; // mirrored coordinates
    vec3 bent = slope.x * right + slope.y * above + slope.z * normal;
    return dot(right, right) > 0.0 && dot(bent, bent) > 0.0 ? unit(bent) : normal;
}
