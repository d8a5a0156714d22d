// Fragments of a layer of transparent surfaces: behind the previous layer, in front of the opaque
// surface (src/raster/layer.h).
#include "interface.h"

layout(binding = UNIT_IDS) uniform usampler2D opaque_ids;
layout(binding = UNIT_NEARNESS) uniform sampler2D opaque_nearness;
layout(binding = UNIT_BEFORE_IDS) uniform usampler2D before_ids;
layout(binding = UNIT_BEFORE_NEARNESS) uniform sampler2D before_nearness;
layout(binding = UNIT_CAPS) uniform sampler2D cap_nearness;
layout(binding = UNIT_BELOW) uniform sampler2D splats_below; // below 0: the pixel is finished

bool is_between(ivec2 pixel, float nearness, uint id)
{
    float before = texelFetch(before_nearness, pixel, 0).r, solid = texelFetch(opaque_nearness, pixel, 0).r;
    bool behind = nearness < before || (nearness == before && id > texelFetch(before_ids, pixel, 0).r);
    bool front = nearness > solid || (nearness == solid && id < texelFetch(opaque_ids, pixel, 0).r);
    front = front && nearness >= texelFetch(cap_nearness, pixel, 0).r;
    return behind && front && texelFetch(splats_below, pixel, 0).r >= 0.0;
}

// The same for a splat: skips other splats of the surface that the previous layer shows.
bool is_splat_between(ivec2 pixel, float nearness, uint id)
{
    return nearness < texelFetch(splats_below, pixel, 0).r && is_between(pixel, nearness, id);
}
