// The visibility buffer: nearness and id.
#include "interface.h"

layout(binding = UNIT_IDS) uniform usampler2D visible_ids;
layout(binding = UNIT_NEARNESS) uniform sampler2D visible_nearness;

// NO_ID: background.
uint read_visible(ivec2 pixel, out float nearness)
{
    nearness = texelFetch(visible_nearness, pixel, 0).r;
    return texelFetch(visible_ids, pixel, 0).r;
}
