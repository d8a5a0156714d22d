// Computes the plane of the visible splat of each pixel.
#include "lib_surface.glsl"
#include "lib_visible.glsl"
#include "lib_conic.glsl"
#include "lib_blend.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba32f, binding = IMAGE_PLANES) uniform writeonly image2D planes;

vec4 find_plane(ivec2 pixel, uint id)
{
    item_block item = items[find_item(id)];
    if (item.kind == KIND_MESH) {
        return vec4(0.0);
    }
    chunk_block chunk = find_chunk(item, id - item.first_id);
    uint local = id - item.first_id - chunk.begin;
    record_block record = record_block(0u, chunk.begin, chunk.address, 1.0, -1e38, 1e38, 0u, 0u);
    splat_shape s;
    uint shape = shape_splat(record, item, place_splat(record, item, local), s);
    if (shape == SHAPE_PIXEL) {
        return vec4(s.center.z, 0.0, 0.0, PLANE_TINY);
    }
    if (shape != SHAPE_DISK) {
        return vec4(0.0);
    }
    float change = dot(s.conic2.zw, vec2(pixel) + 0.5 - s.center.xy);
    float nearness = s.center.z + clamp(change, -s.center.w, s.center.w);
    float side = find_side(vec2(item.slope_factor, item.slope_constant), nearness);
    return vec4(nearness, s.conic2.zw / side, PLANE_DISK);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, ivec2(view.size.xy)))) {
        float nearness;
        uint id = read_visible(pixel, nearness);
        imageStore(planes, pixel, id != NO_ID ? find_plane(pixel, id) : vec4(0.0));
    }
}
