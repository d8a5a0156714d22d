// Squares too large for points, as two triangles; fragments are the same as for points.
#include "lib_conic.glsl"

layout(std430, binding = BINDING_LARGE) readonly buffer Large {
    uint large_vertices, large_count, large_first, large_base;
    uvec2 large_places[];
};

flat out vec4 center; // same as splat.vert.glsl
flat out vec4 conic;
flat out vec4 conic2;
flat out vec2 depths;
flat out vec4 clip;
flat out uvec3 hashed;

void main()
{
    uint number = uint(gl_InstanceID);
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    center = conic = conic2 = clip = vec4(0.0);
    depths = vec2(0.0);
    hashed = uvec3(0u);
    if (number >= uint(LARGE_MAX)) {
        return;
    }
    record_block record = records[large_places[number].x];
    item_block item = items[record.item];
    uint local = large_places[number].y;
    splat_place splat = place_splat(record, item, local);
    splat_shape s;
    shape_splat(record, item, splat, s);
    center = s.center;
    conic = s.conic;
    depths = s.depths;
    clip = s.clip;
    hashed = splat_hash(record, item, local, splat, splat.halvings, false);
    vec2 low = clamp(s.conic.xy, vec2(-1.0), view.size.xy + 1.0);
    vec2 high = clamp(s.conic.zw + 1.0, vec2(-1.0), view.size.xy + 1.0);
    vec2 corner = vec2((gl_VertexID & 1) != 0 ? high.x : low.x, (gl_VertexID & 2) != 0 ? high.y : low.y);
    float bound = clamp(s.center.z * 1.0001, 0.0, 1.0); // fragments write less
    gl_Position = vec4(to_clip(corner, 1.0), bound, 1.0);
}
