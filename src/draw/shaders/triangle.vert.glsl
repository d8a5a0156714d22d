#extension GL_ARB_shader_draw_parameters : require
// Triangles of clusters, with vertex pulling from the pages. KEEP: of cutout and transparent
// materials, of ghosts, and of items cut by sections.
#include "lib_hash.glsl"
#include "lib_triangle.glsl"

flat out uint triangle_id;
#ifdef KEEP
flat out uvec2 triangle_of; // record, and triangle in the cluster
out vec2 weight;
out vec3 place; // in the view, for sections
#endif

// Whether a triangle's level (base/splats/triangle_level.h) is at least the item's level at its nearest
// corner, and that corner is not too near.
bool is_large(const item_block item, const triangle_place t)
{
    vec3 p[3];
    float nearest = 3.4e38;
    for (int k = 0; k < 3; ++k) {
        p[k] = corner_position(t, t.corner[k]);
        nearest = min(nearest, dot(item.rows[3], vec4(p[k] - item.offset.xyz, 1.0)));
    }
    float level = 0.5 * max(distance(p[0], p[1]), max(distance(p[1], p[2]), distance(p[2], p[0])));
    return nearest >= item.large_from && level >= max(item.level_per_depth * nearest, item.level_min);
}

// Whether the back of a triangle is seen: its corners turn clockwise.
bool faces_away(const item_block item, const triangle_place t)
{
    vec3 a = corner_position(t, t.corner.x), b = corner_position(t, t.corner.y), c = corner_position(t, t.corner.z);
    vec3 eye = vec3(item.eye[0], item.eye[1], item.eye[2]);
    vec3 sight = view.parallel != 0u ? eye : eye - (a - item.offset.xyz);
    return dot(cross(b - a, c - a), sight) < 0.0;
}

void main()
{
    uint number = uint(gl_BaseInstanceARB);
    record_block record = records[number];
    item_block item = items[record.item];
    uint local = uint(gl_VertexID) / 3u, corner = uint(gl_VertexID) - 3u * local;
    uint index = fetch(record.address + CLUSTER_FIRST_TRIANGLE) + local;
    triangle_id = item.first_id + index;
#ifdef KEEP
    triangle_of = uvec2(number, local);
    place = vec3(0.0);
    weight = vec2(corner == 1u ? 1.0 : 0.0, corner == 2u ? 1.0 : 0.0);
#endif
    if (record.share < 1.0 && !keeps(index, record.share)) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // all three corners: no pixel
        return;
    }
    triangle_place t = find_triangle(item.address, record.address, local);
    if (((item.flags & ITEM_LARGE) != 0u && !is_large(item, t)) || (local < record.first && faces_away(item, t))) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    vec4 p = vec4(corner_position(t, t.corner[corner]) - item.offset.xyz, 1.0);
    float w = dot(item.rows[3], p), nearness = dot(item.rows[2], p);
    gl_Position = vec4(to_clip(vec2(dot(item.rows[0], p), dot(item.rows[1], p)), w), nearness, w);
#ifdef KEEP
    place = to_view(item, vec4(dot(item.rows[0], p), dot(item.rows[1], p), nearness, w));
#endif
}
