// SPDX-License-Identifier: MIT
#include "lod/levels/division.h"

#include "base/math/math.h"
#include "lod/levels/patches.h"

#include <string.h>

stp_result stp_division_create(stp_context* context, uint32_t triangles, uint32_t items,
                               stp_division* division)
{
    size_t count = (size_t)items + 1;
    *division = (stp_division){.centers = STP_NEW_ARRAY(context, float, 3 * count),
                               .item_of = STP_NEW_ARRAY(context, uint32_t, (size_t)triangles + 1),
                               .members = STP_NEW_ARRAY(context, uint32_t, count),
                               .ends = STP_NEW_ARRAY(context, uint32_t, count)};
    bool good = division->centers != NULL && division->item_of != NULL &&
                division->members != NULL && division->ends != NULL;
    return good ? STP_OK : stp_fail_memory(context);
}

void stp_division_destroy(stp_context* context, stp_division* division)
{
    stp_free(context, division->centers);
    stp_free(context, division->item_of);
    stp_free(context, division->members);
    stp_free(context, division->ends);
    *division = (stp_division){0};
}

stp_result stp_divide(stp_context* context, const uint32_t* indices, uint32_t triangles,
                      uint32_t vertex_count, uint32_t items, uint32_t maximum,
                      stp_division* division)
{
    stp_patch_links links;
    stp_result result = stp_patch_links_make(context, indices, triangles, vertex_count,
                                             division->item_of, items, &links);
    if (result == STP_OK) {
        result = stp_grow_patches(context, &links, division->centers, items, maximum,
                                  division->members, division->ends, &division->patch_count);
    }
    stp_patch_links_destroy(context, &links);
    return result;
}

/// Triangles, single ones of which are the items.
static void fill_single(const float* positions, const uint32_t* indices, uint32_t triangles,
                        stp_division* division)
{
    for (size_t t = 0; t < triangles; ++t) {
        stp_vec3d sum = {0};
        for (size_t k = 0; k < 3; ++k) {
            const float* p = positions + 3 * (size_t)indices[3 * t + k];
            sum = stp_addd(sum, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]});
        }
        stp_vec3 center = stp_to_float(stp_scaled(sum, 1.0 / 3.0));
        memcpy(division->centers + 3 * t, &center, sizeof(center));
        division->item_of[t] = (uint32_t)t;
    }
}

stp_result stp_divide_triangles(stp_context* context, const float* positions, uint32_t vertex_count,
                                const uint32_t* indices, uint32_t triangles, uint32_t maximum,
                                stp_division* division)
{
    stp_result result = stp_division_create(context, triangles, triangles, division);
    if (result != STP_OK) {
        return result;
    }
    fill_single(positions, indices, triangles, division);
    return stp_divide(context, indices, triangles, vertex_count, triangles, maximum, division);
}
