#extension GL_ARB_shader_draw_parameters : require
// Splats as points: the conic of each disk, in a point that holds its pixels. What is too large for that, or close to the
// eye, is noted for the large pass.
#include "lib_splat.glsl"

layout(std430, binding = BINDING_LARGE) buffer Large {
    uint large_vertices, large_count, large_first, large_base;
    uvec2 large_places[];
};

flat out vec4 center;  // x, y, nearness, limit of its change
flat out vec4 conic;   // a, b, c, p
flat out vec4 conic2;  // q, limit, slope of nearness
flat out vec2 depths;  // loss of nearness towards the rim, and the greatest nearness
flat out uvec3 hashed; // id, what holes are hashed from, coverage

void hide()
{
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
}

void leave(uint record, uint local)
{
    uint at = atomicAdd(large_count, 1u);
    if (at < uint(LARGE_MOST)) {
        large_places[at] = uvec2(record, local);
    }
    hide();
}

void draw_pixel(vec2 screen, float nearness)
{
    if (any(lessThan(screen, vec2(0.0))) || any(greaterThanEqual(screen, view.size.xy))) {
        hide();
        return;
    }
    gl_PointSize = 1.0;
    gl_Position = vec4(to_clip(floor(screen) + 0.5, 1.0), nearness, 1.0);
    center = vec4(screen, nearness, 0.0);
    conic = vec4(0.0);
    conic2 = vec4(0.0);
    depths = vec2(0.0, 1.0);
}

void main()
{
    uint number = uint(gl_BaseInstanceARB);
    record_block record = records[number];
    item_block item = items[record.item];
    uint local = uint(gl_VertexID), index = record.first + local;
    splat_place splat = place_splat(record, item, local);
    float w = splat.w, inverse = 1.0 / w;
    vec2 screen = splat.position.xy * inverse;
    float nearness = splat.position.z * inverse, radius = splat.radius;
    uint coverage = splat_coverage(item, index);
    hashed = uvec3(item.first_id + index, item.seed + index, coverage);
    center = conic = conic2 = vec4(0.0);
    depths = vec2(0.0);
    if (!is_wanted(record, item, splat)) {
        hide();
        return;
    }
    if (is_close(item, w)) {
        leave(number, local);
        return;
    }
    if (!(w > 0.0) || !(nearness > 0.0) || !(nearness <= item.nearness_limit)) {
        hide();
        return;
    }
    vec2 a = (screen - vec2(item.center_x, item.center_y)) * item.inverse_scale;
    if (radius * radius * (dot(a, a) + 1.0) <= 0.24) {
        draw_pixel(screen, nearness);
        return;
    }
    bool facing = (item.flags & ITEM_FACING) != 0u;
    vec3 n = facing ? vec3(a, 1.0) : turn_normal(item, splat.code);
    float square = dot(n, n), D = n.x * a.x + n.y * a.y + n.z, least = square * 1e-6;
    float away = D;
    if (D * D < least) { // edge-on: at least a thousandth of the diameter wide
        D = D < 0.0 ? -sqrt(least) : sqrt(least);
    }
    float D2 = D * D, R2 = radius * radius, ratio = radius * item.inverse_scale;
    float L = dot(a, a) + 1.0 - ratio * ratio;
    float linear = -2.0 * (R2 * D * item.inverse_scale);
    float slope = nearness * item.slope_factor + item.slope_constant;
    conic = vec4(D2 - 2.0 * D * n.x * a.x + L * n.x * n.x,
                 2.0 * (L * n.x * n.y - D * (n.x * a.y + n.y * a.x)),
                 D2 - 2.0 * D * n.y * a.y + L * n.y * n.y, linear * n.x);
    conic2 = vec4(linear * n.y, R2 * D2, slope * (n.x / D), slope * (n.y / D));
    vec2 across = a * a + 1.0 - (n.xy - a * n.z) * (n.xy - a * n.z) / square;
    float grow = radius / (1.0 - ratio);
    vec2 extent = grow * sqrt(max(across, vec2(0.0))) + 0.01;
    if (!(max(extent.x, extent.y) < view.point_extent)) {
        leave(number, local);
        return;
    }
    float depth = abs(slope) * radius;
    nearness -= (!facing && away > 0.0 ? item.back_depth : 0.0) * depth;
    center = vec4(screen, nearness, abs(slope) * grow);
    depths = vec2(item.rim_depth * depth / conic2.y, item.nearness_limit);
    // the pixels whose centres may lie in the disk, and the one that its centre lies in
    vec2 first = min(floor(screen - extent + 0.5), floor(screen));
    vec2 last = max(floor(screen + extent - 0.5), floor(screen));
    vec2 size = last - first + 1.0;
    gl_PointSize = max(size.x, size.y);
    float bound = clamp(nearness + center.w, 0.0, 1.0);
    gl_Position = vec4(to_clip(first + 0.5 * gl_PointSize, 1.0), bound, 1.0);
}
