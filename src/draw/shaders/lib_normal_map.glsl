// Normal maps, the same as src/raster/normal_map.c and src/draw/cpu/shade_mesh.c.
#include "lib_texture.glsl"
#include "lib_light.glsl"
#include "lib_eye.glsl"

vec3 to_scene(const item_block item, vec3 n)
{
    return vec3(dot(item.normal[0].xyz, n), dot(item.normal[1].xyz, n), dot(item.normal[2].xyz, n));
}

// Keeps a turned normal on the side of the surface that is seen.
vec3 keep_side(vec3 turned, vec3 normal, vec3 eye)
{
    float side = dot(normal, eye) < 0.0 ? -1.0 : 1.0, facing = side * dot(turned, eye);
    return facing < 0.02 ? unit(turned + eye * (side * (0.02 - facing))) : turned;
}

// A unit normal of the scene, turned by a texel. Placements keep angles, so what turns normals turns
// tangents, too.
vec3 map_normal(const item_block item, const triangle_place t, const vec3 position[3], vec3 normal, vec3 texel,
                ivec2 pixel)
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
    vec3 turned_normal = slope.x * right + slope.y * above + slope.z * normal;
    bool told = dot(right, right) > 0.0 && dot(turned_normal, turned_normal) > 0.0;
    return told ? keep_side(unit(turned_normal), normal, unit(to_eye(vec2(pixel) + 0.5))) : normal;
}
