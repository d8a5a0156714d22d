// Squares instead of disks: src/raster/splats_squares_kernel.h. lib_conic.glsl includes this. In
// splat_shape, `conic` holds the first and the last pixel, and `conic2` is 0; the other fields mean
// the same as for disks.

// Sums use the same order as the CPU, so that the same splat is nearest in a pixel.
uint shape_splat(const record_block record, const item_block item, const splat_place splat, out splat_shape s)
{
    precise float w = splat.w, inverse = 1.0 / w;
    precise vec2 screen = splat.position.xy * inverse;
    precise float nearness = splat.position.z * inverse, radius = splat.radius;
    s = splat_shape(vec4(0.0), vec4(0.0), vec4(0.0), vec2(0.0), vec2(0.0), vec4(0.0, 0.0, -1.0, 1.0));
    if (!is_wanted(record, item, splat) || !(w > 0.0) || !(nearness > 0.0) || !(nearness <= item.nearness_limit)) {
        return SHAPE_NONE;
    }
    precise vec2 a = (screen - vec2(item.center_x, item.center_y)) * item.inverse_scale;
    precise float around = a.x * a.x + a.y * a.y;
    vec2 middle = floor(screen);
    s.center = vec4(screen, nearness, 0.0);
    s.depths = vec2(0.0, item.nearness_limit);
    s.conic = middle.xyxy;
    if (radius * radius * (around + 1.0) <= 0.24) {
        bool inside = all(greaterThanEqual(screen, vec2(0.0))) && all(lessThan(screen, view.size.xy));
        return inside ? SHAPE_PIXEL : SHAPE_NONE;
    }
    bool facing = (item.flags & ITEM_FACING) != 0u;
    precise vec3 n = facing ? vec3(a, 1.0) : turn_normal(item, splat.code);
    precise float D = (n.x * a.x + n.y * a.y) + n.z;
    precise float slope = nearness * item.slope_factor + item.slope_constant, depth = abs(slope) * radius;
    float back_depth = splat.glass ? GLASS_BACK_DEPTH : item.back_depth;
    precise float moved = nearness - (!facing && D >= 0.0 ? back_depth : 0.0) * depth;
    precise vec2 low = (screen - radius) + 0.5, high = (screen + radius) - 0.5;
    s.center.z = max(moved, 1e-30);
    s.extent = vec2(radius);
    s.conic = vec4(min(floor(low), middle), max(floor(high), middle));
    if (splat.part > SPLAT_CLIP && !facing && !splat.glass) {
        vec4 clip = coverage_clip(splat.part - SPLAT_CLIP);
        precise float minimum = ((n.x * n.x + n.y * n.y) + n.z * n.z) * 1e-6;
        D = D * D < minimum ? (D < 0.0 ? -sqrt(minimum) : sqrt(minimum)) : D;
        precise vec3 d = turn_vector(item, clip_direction(splat.code, clip));
        precise float slide = ((d.x * a.x + d.y * a.y) + d.z) / D;
        precise vec2 lines = (d.xy - slide * n.xy) * (1.0 / radius);
        // everything beyond the other side stays
        bool is_half = splat.part - SPLAT_CLIP < COVERAGE_STRIPS;
        s.clip = vec4(lines, is_half ? -1e38 : clip.z, clip.w);
    }
    return is_close(item, splat) || !(radius < view.point_extent) ? SHAPE_LARGE : SHAPE_DISK;
}

vec4 shape_box(const splat_shape s)
{
    return s.conic;
}
