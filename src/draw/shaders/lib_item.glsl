// The frame's items, the commands' records, and the view.
#include "interface.h"
#include "lib_fetch.glsl"

layout(std430, binding = BINDING_ITEMS) readonly buffer Items { item_block items[]; };
layout(std430, binding = BINDING_RECORDS) readonly buffer Records { record_block records[]; };
layout(std140, binding = BINDING_VIEW) uniform View { view_block view; };

// From pixels times w, with the margin around the picture that keeps points whose centre lies outside.
vec2 to_clip(vec2 pixel, float w)
{
    return 2.0 * (pixel + view.margin * w) * view.size.zw - w;
}

// An octahedral code whose full length is `full`; not of unit length.
vec3 decode_octahedral(vec2 code, float full)
{
    float z = full - abs(code.x) - abs(code.y);
    float fold = z < 0.0 ? -z : 0.0;
    code.x += code.x >= 0.0 ? -fold : fold;
    code.y += code.y >= 0.0 ? -fold : fold;
    return vec3(code, z);
}
