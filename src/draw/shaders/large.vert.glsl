// Splats too large for points, as two triangles around the projection of the disk's bounding ball;
// src/raster/splats_large.c.
#include "lib_splat.glsl"

layout(std430, binding = BINDING_LARGE) readonly buffer Large {
    uint large_vertices, large_count, large_first, large_base;
    uvec2 large_places[];
};

// perspective: the centre in the view, in units of W, and the radius. Parallel: on the screen,
// pixels
flat out vec4 middle;
flat out vec4 normal;  // normal in the view, of any length; may face away
flat out vec4 depths;  // nearness (of W = 1, or of the centre), its slope, behind, rim
flat out vec4 screen;  // principal point, 1 / scale, maximum nearness
flat out vec3 across;  // direction across the clip lines, over the radius
flat out vec2 range;   // interval drawn along it
flat out vec4 smaller; // direction of an ellipse's smaller radius, and its weight; 0: a disk
flat out uvec3 hashed; // same as for points

// Extent of a ball's projection along one axis.
vec2 reach(float c, float z, float radius)
{
    if (z - radius <= 0.05 * radius) {
        return vec2(-1e4, 1e4);
    }
    return vec2((c - radius) / (c > radius ? z + radius : z - radius),
                (c + radius) / (c < -radius ? z + radius : z - radius));
}

void main()
{
    uint number = uint(gl_InstanceID);
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    middle = normal = depths = screen = vec4(0.0);
    across = vec3(0.0);
    range = vec2(-1.0, 1.0);
    smaller = vec4(0.0);
    hashed = uvec3(0u);
    if (number >= uint(LARGE_MAX)) {
        return;
    }
    record_block record = records[large_places[number].x];
    item_block item = items[record.item];
    uint local = large_places[number].y, index = record.first + local;
    splat_place splat = place_splat(record, item, local);
    // large splats stay above the minimum, however often they are halved
    uint halvings = splat.glass ? 0u : splat_halvings(splat.part);
    float size = (item.radius_px + item.pixels * splat.w) * splat.own / float(1u << halvings);
    hashed = splat_hash(record, item, local, splat, halvings, false);
    float back_depth = splat.glass ? GLASS_BACK_DEPTH : item.back_depth;
    float rim_depth = splat.glass ? GLASS_RIM_DEPTH : item.rim_depth;
    bool facing = (item.flags & ITEM_FACING) != 0u, parallel = view.parallel != 0u;
    vec2 gaze = vec2(item.center_x, item.center_y);
    vec2 low, high;
    if (parallel) {
        float radius = splat.radius;
        middle = vec4(splat.position.xy, 0.0, radius);
        normal.xyz = facing ? vec3(0.0, 0.0, 1.0) : turn_normal(item, splat.code);
        float behind = !facing && normal.z > 0.0 ? back_depth * radius : 0.0;
        depths = vec4(splat.position.z, -item.slope_constant, behind, rim_depth * radius);
        low = middle.xy - radius - 1.0;
        high = middle.xy + radius + 1.0;
    } else {
        float z = splat.w, inverse = item.inverse_scale;
        float radius = size * inverse;
        middle = vec4((splat.position.xy - gaze * z) * inverse, z, radius);
        normal.xyz = facing ? middle.xyz : turn_normal(item, splat.code);
        float behind = !facing && dot(normal.xyz, middle.xyz) > 0.0 ? back_depth * radius : 0.0;
        depths = vec4(splat.position.z, 0.0, behind, rim_depth * radius);
        vec2 x = reach(middle.x, z, radius), y = reach(middle.y, z, radius);
        low = gaze + vec2(x.x, y.x) / inverse - 1.0;
        high = gaze + vec2(x.y, y.y) / inverse + 1.0;
    }
    if (splat.shape != 0u && !facing) {
        smaller = vec4(turn_vector(item, shape_smaller(splat.code, splat.shape)), shape_stretch(splat.shape));
    }
    if (splat.part > SPLAT_CLIP && !facing && !splat.glass) {
        vec4 clip = coverage_clip(splat.part - SPLAT_CLIP);
        across = turn_vector(item, clip_direction(splat.code, clip)) / middle.w;
        range = clip.zw;
    }
    screen = vec4(gaze, item.inverse_scale, item.nearness_limit);
    low = clamp(low, vec2(-1.0), view.size.xy + 1.0);
    high = clamp(high, vec2(-1.0), view.size.xy + 1.0);
    vec2 corner = vec2((gl_VertexID & 1) != 0 ? high.x : low.x, (gl_VertexID & 2) != 0 ? high.y : low.y);
    gl_Position = vec4(to_clip(corner, 1.0), 0.5, 1.0);
}
