// SPDX-License-Identifier: MIT
#include "base/core/sort.h"
#include "base/math/math.h"
#include "base/math/morton.h"
#include "lod/grid.h"

#include <assert.h>

#define AXIS_BITS 10u

static uint32_t place_on_axis(float coordinate, float low, float scale)
{
    float place = (coordinate - low) * scale;
    return place > 0.0f ? place < 1023.0f ? (uint32_t)place : 1023u : 0u;
}

stp_result stp_sort_spatially(stp_context* context, const float* positions, uint32_t count,
                              uint32_t* order)
{
    uint64_t* keys = STP_NEW_ARRAY(context, uint64_t, 2 * (size_t)count);
    if (keys == NULL) {
        return stp_fail_memory(context);
    }
    stp_box box = stp_box_of(positions, count);
    stp_vec3 extent = stp_sub(box.max, box.min);
    float widest = stp_max(extent.x, stp_max(extent.y, extent.z));
    float scale = widest > 0.0f ? 1023.0f / widest : 0.0f;
    for (uint32_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * (size_t)i;
        uint32_t code =
            stp_morton(place_on_axis(p[0], box.min.x, scale), place_on_axis(p[1], box.min.y, scale),
                       place_on_axis(p[2], box.min.z, scale));
        keys[i] = (uint64_t)code << 32 | i;
    }
    const uint64_t* sorted = stp_sort_u64(keys, keys + count, count, 32, 3 * AXIS_BITS);
    for (uint32_t i = 0; i < count; ++i) {
        assert((i == 0 || sorted[i] > sorted[i - 1]) && "by code, then by index");
        order[i] = (uint32_t)sorted[i];
    }
    stp_free(context, keys);
    return STP_OK;
}
