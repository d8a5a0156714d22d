// The picture of a disk on the screen, as all ways to draw splats know it: src/raster/splats_kernel.h.
#include "lib_splat.glsl"

#define SHAPE_NONE 0u
#define SHAPE_PIXEL 1u // the pixel of its centre alone
#define SHAPE_DISK 2u
#define SHAPE_LARGE 3u // left to the pass for large ones

struct splat_shape {
    vec4 center; // x, y, nearness, limit of its change
    vec4 conic;  // a, b, c, p
    vec4 conic2; // q, limit, slope of nearness
    vec2 depths; // loss of nearness towards the rim, and the greatest nearness
    vec2 extent; // pixels from the centre
};

uint shape_splat(const record_block record, const item_block item, const splat_place splat, out splat_shape s)
{
    float w = splat.w, inverse = 1.0 / w;
    vec2 screen = splat.position.xy * inverse;
    float nearness = splat.position.z * inverse, radius = splat.radius;
    s = splat_shape(vec4(0.0), vec4(0.0), vec4(0.0), vec2(0.0), vec2(0.0));
    if (!is_wanted(record, item, splat)) {
        return SHAPE_NONE;
    }
    if (is_close(item, w)) {
        return SHAPE_LARGE;
    }
    if (!(w > 0.0) || !(nearness > 0.0) || !(nearness <= item.nearness_limit)) {
        return SHAPE_NONE;
    }
    vec2 a = (screen - vec2(item.center_x, item.center_y)) * item.inverse_scale;
    if (radius * radius * (dot(a, a) + 1.0) <= 0.24) {
        s.center = vec4(screen, nearness, 0.0);
        s.depths = vec2(0.0, 1.0);
        bool inside = all(greaterThanEqual(screen, vec2(0.0))) && all(lessThan(screen, view.size.xy));
        return inside ? SHAPE_PIXEL : SHAPE_NONE;
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
    s.conic = vec4(D2 - 2.0 * D * n.x * a.x + L * n.x * n.x,
                   2.0 * (L * n.x * n.y - D * (n.x * a.y + n.y * a.x)),
                   D2 - 2.0 * D * n.y * a.y + L * n.y * n.y, linear * n.x);
    s.conic2 = vec4(linear * n.y, R2 * D2, slope * (n.x / D), slope * (n.y / D));
    vec2 across = a * a + 1.0 - (n.xy - a * n.z) * (n.xy - a * n.z) / square;
    float grow = radius / (1.0 - ratio);
    s.extent = grow * sqrt(max(across, vec2(0.0))) + 0.01;
    if (!(max(s.extent.x, s.extent.y) < view.point_extent)) {
        return SHAPE_LARGE;
    }
    float depth = abs(slope) * radius;
    nearness -= (!facing && away > 0.0 ? item.back_depth : 0.0) * depth;
    s.center = vec4(screen, nearness, abs(slope) * grow);
    s.depths = vec2(item.rim_depth * depth / s.conic2.y, item.nearness_limit);
    return SHAPE_DISK;
}

// The pixels whose centres may lie in the disk, and the one that its centre lies in: first and last.
vec4 shape_box(const splat_shape s)
{
    vec2 middle = floor(s.center.xy);
    return vec4(min(floor(s.center.xy - s.extent + 0.5), middle), max(floor(s.center.xy + s.extent - 0.5), middle));
}
