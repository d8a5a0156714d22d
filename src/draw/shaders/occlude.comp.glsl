// Occlusion culling of commands by their boxes. First pass: defers commands that the previous
// picture occludes. Second pass: draws deferred commands that this picture's own depths do not
// occlude, and disables all others.
#include "lib_item.glsl"
#include "lib_pyramid.glsl"

layout(local_size_x = OCCLUDE_GROUP) in;

layout(std430, binding = BINDING_OCCLUDED_COMMANDS) buffer Commands { uvec4 commands[]; };
layout(std430, binding = BINDING_PYRAMID) readonly buffer Pyramid { float nearest[]; };
// number of commands deferred after the first pass, and culled in the end
layout(std430, binding = BINDING_COUNTERS) buffer Counters { uint set_aside[2]; };

layout(location = 0) uniform uint command_count;
layout(location = 1) uniform uint stage; // 0: tests the previous picture, 1: this one

const float SLACK = 1.0 + 1e-4;  // triangles' depths differ in the fifth digit
const int MAX_BLOCKS = 8;       // maximum blocks per side of a box; larger ones are rarely occluded

// From X, Y, N, W of this view to those of the previous picture.
vec4 to_earlier(const item_block item, vec4 at)
{
    at.z *= item.near_factor;
    vec4 turned = vec4(dot(view.earlier[0], at), dot(view.earlier[1], at), dot(view.earlier[2], at), dot(view.earlier[3], at));
    turned.z /= item.near_factor;
    return turned;
}

// Whether everything in a rectangle of pixels at nearness up to `near` is occluded.
bool is_covered(vec2 low, vec2 high, float near)
{
    ivec2 size = ivec2(view.size.xy);
    if (any(lessThan(high, vec2(0.0))) || any(greaterThanEqual(low, view.size.xy)) || any(isnan(low)) || any(isnan(high))) {
        return false;
    }
    ivec2 first = ivec2(max(low, vec2(0.0))), last = ivec2(min(high, view.size.xy - 1.0));
    int across = max(last.x - first.x, last.y - first.y) + 1, level = 0;
    while (level < PYRAMID_LEVELS - 1 && (PYRAMID_BLOCK << level) * 3 < across) {
        level += 1;
    }
    int shift = PYRAMID_SHIFT + level, columns = count_blocks(size, level).x, offset = find_level(size, level);
    ivec2 begin = first >> shift, end = last >> shift;
    if (any(greaterThanEqual(end - begin, ivec2(MAX_BLOCKS)))) {
        return false;
    }
    bool covered = true;
    for (int y = begin.y; y <= end.y; ++y) {
        for (int x = begin.x; x <= end.x; ++x) {
            covered = covered && nearest[offset + y * columns + x] > near;
        }
    }
    return covered;
}

bool is_hidden(const item_block item, float reach, vec3 box_low, vec3 box_high)
{
    vec2 low = vec2(1e30), high = vec2(-1e30);
    float minimum = 1e30, near = 0.0;
    for (int i = 0; i < 8; ++i) {
        vec4 p = vec4((i & 1) != 0 ? box_high.x : box_low.x, (i & 2) != 0 ? box_high.y : box_low.y,
                      (i & 4) != 0 ? box_high.z : box_low.z, 1.0);
        vec4 at = vec4(dot(item.rows[0], p), dot(item.rows[1], p), dot(item.rows[2], p), dot(item.rows[3], p));
        at = stage == 0u ? to_earlier(item, at) : at;
        vec2 screen = at.xy / at.w;
        low = min(low, screen);
        high = max(high, screen);
        minimum = min(minimum, at.w);
        near = max(near, at.z);
    }
    // maximum nearness of disks centred in the box, and their overhang beyond it on the screen
    float radius = item.kind == KIND_MESH ? 0.0 : item.radius_px * reach;
    float front = minimum - radius * item.inverse_scale;
    if (!(front > 0.1 * minimum) || !(minimum > 0.0)) {
        return false;
    }
    float beyond = radius / front * (1.0 + view.corner) + 2.0;
    return is_covered(low - beyond, high + beyond, near / front * SLACK);
}

void main()
{
    uint index = gl_GlobalInvocationID.x;
    if (index >= command_count) {
        return;
    }
    uvec4 command = commands[index];
    record_block record = records[command.w];
    item_block item = items[record.item];
    vec3 low = item.box_low.xyz, high = item.box_high.xyz;
    if (item.kind == KIND_MESH) {
        low = fetch_vec3(record.address + CLUSTER_BOX) - item.offset.xyz;
        high = fetch_vec3(record.address + CLUSTER_BOX + 3u) - item.offset.xyz;
    }
    bool aside = stage == 0u || command.y == 0u;
    bool hidden = aside && is_hidden(item, record.reach, low, high);
    commands[index].y = (stage == 0u ? !hidden : aside && !hidden) ? 1u : 0u;
    if (hidden) {
        atomicAdd(set_aside[stage], 1u);
    }
}
