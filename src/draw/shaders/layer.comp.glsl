// Composites a drawn layer in linear light.
#include "lib_surface.glsl"
#include "lib_visible.glsl"
#include "lib_eye.glsl"
#include "lib_recolor.glsl"

layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;
layout(rgba32f, binding = IMAGE_LIGHT) uniform image2D light;
layout(r32f, binding = IMAGE_BELOW) uniform image2D below;
layout(r32ui, binding = IMAGE_OPTICAL) uniform readonly uimage2D optical_depths;
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint covered, layered; };

// Minimum nearness of splats that belong to this splat's surface.
float find_below(const item_block item, float nearness)
{
    float thickness = GLASS_THICKNESS * item.glass_radius;
    return view.parallel != 0u ? nearness + view.nearness_scale * thickness
                               : view.nearness_scale / (view.nearness_scale / nearness + thickness);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(view.size.xy)))) {
        return;
    }
    float nearness;
    uint id = read_visible(pixel, nearness);
    if (id == NO_ID) {
        return;
    }
    item_block item = items[find_item(id)];
    float depth = item.near_factor * nearness + item.near_shift;
    surface s = find_surface(item, id, pixel, depth);
    vec2 at = vec2(pixel) + 0.5;
    move_to_center(item, id, at, depth);
    recolor(s, at, depth);
    vec3 color = light_surface(s.color, s.normal, s.apart, to_eye(vec2(pixel) + 0.5), s.light);
    vec4 so_far = imageLoad(light, pixel);
    float opacity = clamp(s.opacity, 0.0, 1.0);
    if (view.nearest_only != 0u) { // the layer stands for all; the depths include its triangle
        float clear = exp2(float(imageLoad(optical_depths, pixel).r) * (-1.0 / float(OPTICAL_UNIT)));
        opacity = 1.0 - (item.kind != KIND_MESH ? 1.0 - opacity : 1.0) * clear;
    }
    float share = so_far.a * opacity;
    so_far += share * vec4(clamp(color, 0.0, 1.0), -1.0);
    imageStore(light, pixel, so_far);
    if (so_far.a < LAYERS_CLEAR) {
        imageStore(below, pixel, vec4(-1.0));
    } else if (item.kind != KIND_MESH) {
        imageStore(below, pixel, vec4(find_below(item, nearness)));
    }
    atomicAdd(layered, 1u);
}
