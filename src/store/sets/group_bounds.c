// SPDX-License-Identifier: MIT
// Bounds of groups of neighbouring splats: a box and a cone of normals, for culling.
#include "base/splats/octahedral.h"
#include "base/splats/splat_codes.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

static void add_box(const stp_splats* s, uint32_t index, stp_splat_group* group)
{
    const uint16_t* p = s->positions + 3 * (size_t)index;
    for (int k = 0; k < 3; ++k) {
        group->low[k] = p[k] < group->low[k] ? p[k] : group->low[k];
        group->high[k] = p[k] > group->high[k] ? p[k] : group->high[k];
    }
    uint16_t larger = s->shapes != NULL ? (uint16_t)(s->shapes[index] & 0xFFFu) : 0;
    group->largest = larger > group->largest ? larger : group->largest;
    if (s->shapes != NULL && (s->columns & STP_SPLATS_REPLACED) != 0 &&
        stp_shape_is_replaced(s->shapes[index])) {
        group->replaced |= UINT64_C(1) << index % STP_GROUP_SPLATS;
    }
}

// A cone around the mean of the normals, rounded outwards.
static void add_cone(const stp_splats* s, uint32_t begin, uint32_t end, stp_splat_group* group)
{
    bool tells = (s->columns & STP_SPLATS_REPLACED) != 0;
    stp_vec3 sum = {0};
    for (uint32_t i = begin; i < end; ++i) {
        const int8_t* code = s->normals + 2 * (size_t)i;
        stp_vec3 n = stp_octahedral_decode(code[0], code[1]);
        sum = (stp_vec3){sum.x + n.x, sum.y + n.y, sum.z + n.z};
    }
    group->sine = 255;
    if (!(stp_dot(sum, sum) > 0.0f)) {
        return;
    }
    stp_vec3 axis = stp_normalize(sum);
    const float parts[3] = {axis.x, axis.y, axis.z};
    for (int k = 0; k < 3; ++k) {
        group->axis[k] = (int8_t)(parts[k] * 127.0f + (parts[k] < 0.0f ? -0.5f : 0.5f));
    }
    stp_vec3 rounded = stp_normalize(
        (stp_vec3){(float)group->axis[0], (float)group->axis[1], (float)group->axis[2]});
    float minimum = 1.0f;
    for (uint32_t i = begin; i < end; ++i) {
        const int8_t* code = s->normals + 2 * (size_t)i;
        float cosine = stp_dot(stp_octahedral_decode(code[0], code[1]), rounded);
        float spread = s->shapes != NULL ? stp_shape_spread(s->shapes[i], tells) : 1.0f;
        // cosine of the sum of both angles
        float both = cosine * sqrtf(1.0f - spread * spread) -
                     spread * sqrtf(fmaxf(1.0f - cosine * cosine, 0.0f));
        minimum = both < minimum ? both : minimum;
    }
    if (minimum > 0.0f) {
        float sine = 255.0f * sqrtf(1.0f - minimum * minimum) + 1.0f;
        group->sine = sine < 255.0f ? (uint8_t)sine : 255;
    }
}

void stp_store_make_groups(const stp_splats* s, uint32_t first, uint32_t end)
{
    assert(first <= end);
    for (uint32_t begin = first / STP_GROUP_SPLATS * STP_GROUP_SPLATS;
         s->groups != NULL && begin < end; begin += STP_GROUP_SPLATS) {
        stp_splat_group* group = &s->groups[begin / STP_GROUP_SPLATS];
        uint32_t after = end - begin < STP_GROUP_SPLATS ? end : begin + STP_GROUP_SPLATS;
        *group = (stp_splat_group){.low = {UINT16_MAX, UINT16_MAX, UINT16_MAX}};
        for (uint32_t i = begin; i < after; ++i) {
            add_box(s, i, group);
        }
        assert(group->low[0] <= group->high[0] && group->low[1] <= group->high[1] &&
               group->low[2] <= group->high[2]);
        add_cone(s, begin, after, group);
    }
}
