// The frame's items, the commands' records, and the view.
#include "interface.h"
#include "lib_fetch.glsl"

layout(std430, binding = BINDING_ITEMS) readonly buffer Items { item_block items[]; };
layout(std430, binding = BINDING_RECORDS) readonly buffer Records { record_block records[]; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

// From pixels times w to clip space, with a margin around the picture so that points with centres
// outside are not clipped.
vec2 to_clip(vec2 pixel, float w)
{
    return 2.0 * (pixel + view.margin * w) * view.size.zw - w;
}

// Decodes an octahedral code with maximum `full`; the result is not normalized.
vec3 decode_octahedral(vec2 code, float full)
{
    float z = full - abs(code.x) - abs(code.y);
    float fold = z < 0.0 ? -z : 0.0;
    code.x += code.x >= 0.0 ? -fold : fold;
    code.y += code.y >= 0.0 ? -fold : fold;
    return vec3(code, z);
}

// Right, down and depth of the point at X, Y, N, W.
vec3 to_view(const item_block item, vec4 at)
{
    vec2 across = (at.xy - view.screen.xy * at.w) * view.screen.z;
    float deep = (at.z + item.near_shift - view.nearness_offset) / view.nearness_scale;
    return vec3(across, view.parallel != 0u ? deep : at.w);
}

// Whether a position in the view is cut away. Points in the plane itself stay, regardless of
// rounding.
bool is_beyond_section(const item_block item, vec3 at)
{
    for (uint i = 0u; i < uint(SECTION_PLANES); ++i) {
        vec4 row = view.section_rows[i];
        float size = dot(abs(row.xyz), abs(at)) + abs(row.w), slack = item.section_slack * length(row.xyz);
        if ((item.sections >> i & 1u) != 0u && dot(row.xyz, at) + row.w > 4e-6 * size + slack) {
            return true;
        }
    }
    return false;
}
