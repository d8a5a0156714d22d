// Deferred shading of the visibility buffer: each pixel is shaded once. With supersampling, adds
// samples to sums.
#include "lib_surface.glsl"
#include "lib_visible.glsl"
#include "lib_eye.glsl"
#include "lib_recolor.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba8, binding = IMAGE_PICTURE) uniform writeonly image2D picture;
layout(r32f, binding = IMAGE_DEPTH) uniform writeonly image2D depths;
#ifdef SUMS
layout(rgba32f, binding = IMAGE_SUMS) uniform image2D sums;
#endif
#ifdef KINDS
layout(r8ui, binding = IMAGE_KINDS) uniform writeonly uimage2D kinds;
#endif
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered; };

layout(binding = UNIT_BLENDED) uniform sampler2D blends; // sums of weighted colours, and of weights

shared uint group_covered;

// @return linear colour
vec3 shade(ivec2 pixel, uint id, float nearness, out float depth, out bool splat)
{
    item_block item = items[find_item(id)];
    splat = item.kind != KIND_MESH;
    depth = item.near_factor * nearness + item.near_shift;
    vec4 blended = view.filtered != FILTER_NONE && item.kind != KIND_MESH ? texelFetch(blends, pixel, 0) : vec4(0.0);
    if (blended.a > 0.0) {
        return blended.rgb / blended.a;
    }
    surface s = find_surface(item, id, pixel, depth);
    vec2 at = vec2(pixel) + 0.5;
    float place_depth = depth;
    move_to_center(item, id, at, place_depth);
    recolor(s, at, place_depth);
    return light_surface(s.color, s.normal, s.apart, to_eye(vec2(pixel) + 0.5), s.light);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    bool inside = all(lessThan(pixel, ivec2(view.size.xy)));
    if (gl_LocalInvocationIndex == 0u) {
        group_covered = 0u;
    }
    barrier();
    if (inside) {
        float nearness, depth = 0.0;
        uint id = read_visible(pixel, nearness);
        bool there = id != NO_ID, splat = false;
        vec3 color = vec3(0.0);
        if (there) {
            color = shade(pixel, id, nearness, depth, splat);
            atomicAdd(group_covered, view.counts);
        }
        imageStore(depths, pixel + ivec2(0, view.depth_y), vec4(depth, 0.0, 0.0, 0.0));
        ivec2 place = pixel + ivec2(view.picture_x, 0);
#ifdef KINDS
        imageStore(kinds, pixel, uvec4(splat ? 1u : 0u));
#endif
#ifdef SUMS
        vec4 sum = there ? vec4(min(color, vec3(1.0)), 1.0) : vec4(0.0);
        if (view.sample_number > 0u) {
            sum += imageLoad(sums, place);
        }
        imageStore(sums, place, sum);
#else
        vec4 back = view.background.w > 0.0 && view.counts > 0u ? vec4(encode(view.background.rgb), 1.0) : vec4(0.0);
        imageStore(picture, place, there ? vec4(encode(color), 1.0) : back);
#endif
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && group_covered > 0u) {
        atomicAdd(covered, group_covered);
    }
}
