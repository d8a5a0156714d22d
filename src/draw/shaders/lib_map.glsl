// Texture mapping of a splat's disk or ellipse: screen directions of its larger and smaller axes,
// over their radii (src/raster/splats_blend_kernel.h). Accurate to first order; fragments divide by
// their depth.

vec2 map_axis(vec3 d, vec3 n, vec2 a, float D)
{
    float slide = (dot(d.xy, a) + d.z) / D;
    return d.xy - slide * n.xy;
}

vec4 map_texture(const item_block item, const splat_place splat, const splat_shape s)
{
    float inverse = 1.0 / splat.radius;
    if ((item.flags & ITEM_FACING) != 0u) {
        return vec4(inverse, 0.0, 0.0, inverse);
    }
    vec2 a = (s.center.xy - vec2(item.center_x, item.center_y)) * item.inverse_scale;
    vec3 n = turn_normal(item, splat.code);
    float D = dot(n.xy, a) + n.z, minimum = dot(n, n) * 1e-6;
    D = D * D < minimum ? (D < 0.0 ? -sqrt(minimum) : sqrt(minimum)) : D;
    bool stretched = splat.shape != 0u && (splat.shape & 0xFFFu) != (splat.shape >> 12 & 0xFFFu);
    float turn = stretched ? float(splat.shape >> 24) * (3.14159265 / 256.0) : 0.0;
    vec2 smaller = vec2(-sin(turn), cos(turn));
    float stretch = stretched ? sqrt(1.0 + shape_stretch(splat.shape)) : 1.0;
    vec3 along = turn_vector(item, clip_direction(splat.code, vec4(smaller.y, -smaller.x, 0.0, 0.0)));
    vec3 across = turn_vector(item, clip_direction(splat.code, vec4(smaller, 0.0, 0.0)));
    return vec4(map_axis(along, n, a, D), stretch * map_axis(across, n, a, D)) * inverse;
}
