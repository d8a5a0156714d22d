// SPDX-License-Identifier: MIT
#include "lod/stochastic/patch_links.h"

#include "lod/psp/nearest_points.h"

#include <string.h>

enum { GRAIN = 256 };
#define BENT 3.0f      // what a step weighs whose ends do not lie on an even bend
#define ACROSS 2.0f    // a step straight from a surface to another
#define ONE_SIDED 0.5f // what a link counts that only one patch has among those near it
#define LEAST 0.1f     // weight at which steps count no more than others

typedef struct link_loop {
    const stp_patches* patches;
    stp_patch_links* links;
} link_loop;

static void weigh(const stp_patch* a, const stp_patch* b, stp_patch_link* link)
{
    stp_vec3 way = stp_normalize(stp_sub(b->place, a->place));
    float leaves = stp_dot(way, a->normal), enters = stp_dot(way, b->normal);
    float product = stp_dot(a->normal, b->normal) - 2.0f * leaves * enters;
    float across = stp_max(fabsf(leaves), fabsf(enters));
    link->weight = BENT * (1.0f - stp_min(fabsf(product), 1.0f)) + ACROSS * across * across +
                   a->doubt + b->doubt;
    float weight = LEAST + link->weight;
    link->agreement *= product / (weight * weight);
}

float stp_patch_agreement(const stp_patch* a, const stp_patch* b)
{
    stp_patch_link link = {.agreement = 1.0f};
    weigh(a, b, &link);
    return link.agreement;
}

/// Both ends of a link get the same bits: the patch of the lower number is the first.
static void weigh_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const link_loop* l = user;
    const stp_patch* all = l->patches->all;
    for (size_t i = begin; i < end; ++i) {
        for (uint32_t k = l->links->begins[i]; k < l->links->begins[i + 1]; ++k) {
            stp_patch_link* link = &l->links->all[k];
            size_t low = i < link->to ? i : link->to, high = i < link->to ? link->to : i;
            weigh(&all[low], &all[high], link);
        }
    }
}

/// Whether a patch lists another one among those near it.
static bool lists(const uint32_t* neighbours, uint32_t near, uint32_t patch, uint32_t other)
{
    const uint32_t* own = neighbours + (size_t)near * patch;
    for (uint32_t i = 0; i < near; ++i) {
        if (own[i] == other) {
            return true;
        }
    }
    return false;
}

/// Counts links, or writes them where there is room.
static void join(const uint32_t* neighbours, uint32_t near, uint32_t count, stp_patch_links* links)
{
    for (uint32_t a = 0; a < count; ++a) {
        for (uint32_t i = 0; i < near; ++i) {
            uint32_t b = neighbours[(size_t)near * a + i];
            bool both = b != UINT32_MAX && lists(neighbours, near, b, a);
            if (b == UINT32_MAX || (a > b && both)) {
                continue;
            }
            if (links->all == NULL) {
                links->begins[a + 2] += 1;
                links->begins[b + 2] += 1;
            } else {
                float share = both ? 1.0f : ONE_SIDED;
                links->all[links->begins[a + 1]++] = (stp_patch_link){.to = b, .agreement = share};
                links->all[links->begins[b + 1]++] = (stp_patch_link){.to = a, .agreement = share};
            }
        }
    }
}

stp_result stp_patch_links_make(stp_context* context, const stp_patches* patches, uint32_t near,
                                stp_patch_links* links)
{
    uint32_t count = patches->count;
    float* places = STP_NEW_ARRAY(context, float, 3 * (size_t)count + 1);
    uint32_t* neighbours = STP_NEW_ARRAY(context, uint32_t, (size_t)near * count + 1);
    *links = (stp_patch_links){.begins = STP_NEW_ZEROED(context, uint32_t, (size_t)count + 2)};
    stp_result result = places == NULL || neighbours == NULL || links->begins == NULL
                            ? stp_fail_memory(context)
                            : STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        memcpy(places + 3 * i, &patches->all[i].place, 3 * sizeof(float));
    }
    if (result == STP_OK) {
        result = stp_find_nearest_points(context, places, count, near, neighbours);
    }
    if (result == STP_OK) {
        join(neighbours, near, count, links);
        for (uint32_t i = 2; i < count + 2; ++i) {
            links->begins[i] += links->begins[i - 1];
        }
        links->count = links->begins[count + 1];
        links->all = STP_NEW_ARRAY(context, stp_patch_link, links->count + 1);
        result = links->all == NULL ? stp_fail_memory(context) : STP_OK;
    }
    if (result == STP_OK) {
        join(neighbours, near, count, links);
        link_loop loop = {patches, links};
        stp_parallel_for(context, count, GRAIN, weigh_some, &loop);
    }
    stp_free(context, neighbours);
    stp_free(context, places);
    return result;
}

void stp_patch_links_destroy(stp_context* context, stp_patch_links* links)
{
    stp_free(context, links->all);
    stp_free(context, links->begins);
    *links = (stp_patch_links){0};
}
