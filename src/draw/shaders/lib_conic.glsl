// Projection of a disk, shared by all splat paths: src/raster/splats_kernel.h.
#include "lib_splat.glsl"

#define SHAPE_NONE 0u
#define SHAPE_PIXEL 1u // only the pixel of its centre
#define SHAPE_DISK 2u
#define SHAPE_LARGE 3u // left to the large pass

struct splat_shape {
    vec4 center; // x, y, nearness, limit of its change
    vec4 conic;  // a, b, c, p
    vec4 conic2; // q, limit, slope of nearness
    vec2 depths; // loss of nearness towards the rim, and maximum nearness
    vec2 extent; // pixels from the centre
    vec4 clip;    // lines: x * u + y * v within z and w, (u, v) from the centre
};

#ifdef SQUARE
#include "lib_square.glsl"
#else
// Sums use the same order as the CPU, so that the same splat is nearest in a pixel.
uint shape_splat(const record_block record, const item_block item, const splat_place splat, out splat_shape s)
{
    precise float w = splat.w, inverse = 1.0 / w;
    precise vec2 screen = splat.position.xy * inverse;
    precise float nearness = splat.position.z * inverse, radius = splat.radius;
    s = splat_shape(vec4(0.0), vec4(0.0), vec4(0.0), vec2(0.0), vec2(0.0), vec4(0.0, 0.0, -1.0, 1.0));
    if (!is_wanted(record, item, splat)) {
        return SHAPE_NONE;
    }
    if (is_close(item, splat)) {
        return SHAPE_LARGE;
    }
    if (!(w > 0.0) || !(nearness > 0.0) || !(nearness <= item.nearness_limit)) {
        return SHAPE_NONE;
    }
    precise vec2 a = (screen - vec2(item.center_x, item.center_y)) * item.inverse_scale;
    precise float around = a.x * a.x + a.y * a.y;
    if (radius * radius * (around + 1.0) <= 0.24) {
        s.center = vec4(screen, nearness, 0.0);
        s.depths = vec2(0.0, 1.0);
        bool inside = all(greaterThanEqual(screen, vec2(0.0))) && all(lessThan(screen, view.size.xy));
        return inside ? SHAPE_PIXEL : SHAPE_NONE;
    }
    bool facing = (item.flags & ITEM_FACING) != 0u;
    precise vec3 n = facing ? vec3(a, 1.0) : turn_normal(item, splat.code);
    precise float square = (n.x * n.x + n.y * n.y) + n.z * n.z;
    precise float D = (n.x * a.x + n.y * a.y) + n.z, minimum = square * 1e-6, D2 = D * D;
    if (D2 < minimum) { // edge-on: at least a thousandth of the diameter wide
        D = D < 0.0 ? -sqrt(minimum) : sqrt(minimum);
        D2 = D * D;
    }
    precise float R2 = radius * radius, ratio = radius * item.inverse_scale;
    precise float L = (around + 1.0) - ratio * ratio;
    precise float conic_a = (D2 - 2.0 * (D * (n.x * a.x))) + L * (n.x * n.x);
    precise float conic_b = 2.0 * (L * (n.x * n.y) - D * (n.x * a.y + n.y * a.x));
    precise float conic_c = (D2 - 2.0 * (D * (n.y * a.y))) + L * (n.y * n.y);
    if (splat.shape != 0u && (splat.shape & 0xFFFu) != (splat.shape >> 12 & 0xFFFu) && !facing) {
        precise vec3 d = turn_vector(item, shape_smaller(splat.code, splat.shape));
        precise float slide = ((d.x * a.x + d.y * a.y) + d.z) / D, more = shape_stretch(splat.shape) * D2;
        precise vec2 line = d.xy - slide * n.xy;
        conic_a += more * (line.x * line.x);
        conic_b += 2.0 * (more * (line.x * line.y));
        conic_c += more * (line.y * line.y);
    }
    precise float linear = -2.0 * ((R2 * D) * item.inverse_scale);
    precise float slope = nearness * item.slope_factor + item.slope_constant;
    precise vec2 pq = linear * n.xy, slopes = slope * (n.xy / D);
    precise vec2 tilt = n.xy - a * n.z, across = (a * a + 1.0) - tilt * tilt / square;
    precise float grow = radius / (1.0 - ratio), depth = abs(slope) * radius, limit = R2 * D2;
    s.extent = grow * sqrt(max(across, vec2(0.0))) + 0.01;
    if (!(max(s.extent.x, s.extent.y) < view.point_extent)) {
        return SHAPE_LARGE;
    }
    float back_depth = splat.glass ? GLASS_BACK_DEPTH : item.back_depth;
    float rim_depth = splat.glass ? GLASS_RIM_DEPTH : item.rim_depth;
    precise float moved = nearness - (!facing && D > 0.0 ? back_depth : 0.0) * depth;
    s.conic = vec4(conic_a, conic_b, conic_c, pq.x);
    s.conic2 = vec4(pq.y, limit, slopes);
    s.center = vec4(screen, moved, abs(slope) * grow);
    s.depths = vec2(rim_depth * depth / limit, item.nearness_limit);
    if (splat.part > SPLAT_CLIP && !facing && !splat.glass) {
        vec4 clip = coverage_clip(splat.part - SPLAT_CLIP);
        precise vec3 d = turn_vector(item, clip_direction(splat.code, clip));
        precise float slide = ((d.x * a.x + d.y * a.y) + d.z) / D;
        precise vec2 lines = (d.xy - slide * n.xy) * (1.0 / radius);
        s.clip = vec4(lines, clip.zw);
    }
    return SHAPE_DISK;
}

// First and last pixel whose centres may lie in the disk, including the pixel of its centre.
vec4 shape_box(const splat_shape s)
{
    vec2 middle = floor(s.center.xy);
    return vec4(min(floor(s.center.xy - s.extent + 0.5), middle), max(floor(s.center.xy + s.extent - 0.5), middle));
}
#endif
