#extension GL_ARB_shader_draw_parameters : require
// Splats as points for blending, each lit like a pixel at its centre. Large ones are skipped;
// LEAVES queues them.
#include "lib_conic.glsl"
#include "lib_surface.glsl"
#include "lib_eye.glsl"
#ifdef LEAVES
#include "lib_large.glsl"
#endif
#ifdef TEXTURED
#include "lib_map.glsl"
#endif

flat out vec4 center; // as splat_shape
flat out vec4 conic;
flat out vec4 conic2;
flat out vec4 color;  // linear, and the radius in pixels
flat out vec4 ray;    // principal point, 1 / scale, and whether it is a one-pixel splat
flat out vec4 clip;
flat out vec2 slope;  // factor and constant of the nearness difference of a pixel side (find_side)
#ifdef LEAVES
flat out vec2 depths;
#endif
#ifdef TEXTURED
flat out vec4 axes; // the texture's, see lib_map.glsl
#endif
flat out uvec3 hashed;

void main()
{
    uint number = uint(gl_BaseInstanceARB);
    record_block record = records[number];
    item_block item = items[record.item];
    uint local = uint(gl_VertexID), index = record.first + local;
    splat_place splat = place_splat(record, item, local);
    splat_shape s;
    uint shape = shape_splat(record, item, splat, s);
    center = s.center;
    conic = s.conic;
    conic2 = s.conic2;
    clip = s.clip;
#ifdef TEXTURED
    axes = shape == SHAPE_DISK ? map_texture(item, splat, s) : vec4(0.0);
#endif
#ifdef LEAVES
    depths = s.depths;
#endif
    ray = vec4(item.center_x, item.center_y, item.inverse_scale, shape == SHAPE_PIXEL ? 1.0 : 0.0);
    slope = vec2(item.slope_factor, item.slope_constant);
    hashed = uvec3(item.first_id + index, item.seed + index, splat_coverage(item, splat.part, splat.halvings, shape == SHAPE_PIXEL));
    color = vec4(0.0);
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // no pixel
    gl_PointSize = 1.0;
#ifdef LEAVES
    if (shape == SHAPE_LARGE) {
        leave(number, local);
    }
#endif
    if (shape != SHAPE_PIXEL && shape != SHAPE_DISK) {
        return;
    }
    surface found = find_surface(item, item.first_id + index, ivec2(floor(s.center.xy)), 1.0);
    vec3 lit =
        light_surface(found.color, found.normal, found.apart, to_eye(s.center.xy), found.light);
    color = vec4(clamp(lit, 0.0, 1.0), splat.radius);
    vec4 box = shape == SHAPE_DISK ? shape_box(s) : floor(s.center.xyxy);
    vec2 size = box.zw - box.xy + 1.0;
    gl_PointSize = max(size.x, size.y);
    gl_Position = vec4(to_clip(box.xy + 0.5 * gl_PointSize, 1.0), 0.5, 1.0);
}
