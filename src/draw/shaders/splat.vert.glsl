#extension GL_ARB_shader_draw_parameters : require
// Splats as points: the conic of each disk, in a point that contains its pixels. Splats that are
// too large, or close to the eye, are queued for the large pass.
#include "lib_conic.glsl"
#include "lib_large.glsl"

flat out vec4 center;  // as splat_shape
flat out vec4 conic;
flat out vec4 conic2;
flat out vec2 depths;
flat out vec4 clip;
flat out uvec3 hashed; // id, hash key of holes, coverage

void main()
{
    uint number = uint(gl_BaseInstanceARB);
    record_block record = records[number];
    item_block item = items[record.item];
    uint local = uint(gl_VertexID);
    splat_place splat = place_splat(record, item, local);
    splat_shape s;
    uint shape = shape_splat(record, item, splat, s);
    center = s.center;
    conic = s.conic;
    conic2 = s.conic2;
    depths = s.depths;
    clip = s.clip;
    hashed = splat_hash(record, item, local, splat, splat.halvings, shape == SHAPE_PIXEL);
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // no pixel
    gl_PointSize = 1.0;
    if (shape == SHAPE_LARGE) {
        leave(number, local);
    } else if (shape == SHAPE_PIXEL) {
        gl_Position = vec4(to_clip(floor(s.center.xy) + 0.5, 1.0), s.center.z, 1.0);
    } else if (shape == SHAPE_DISK) {
        vec4 box = shape_box(s);
        vec2 size = box.zw - box.xy + 1.0;
        gl_PointSize = max(size.x, size.y);
        float bound = clamp(s.center.z + s.center.w, 0.0, 1.0);
        gl_Position = vec4(to_clip(box.xy + 0.5 * gl_PointSize, 1.0), bound, 1.0);
    }
}
