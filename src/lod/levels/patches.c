// SPDX-License-Identifier: MIT
#include "lod/levels/patches.h"

#include "base/core/sort.h"
#include "base/math/math.h"
#include "lod/grid.h"
#include "lod/levels/mesh_edges.h"

#include <assert.h>

#define NONE UINT32_MAX

typedef struct grower {
    const stp_patch_links* links;
    const float* centers;
    uint32_t count;
    uint32_t* order;    ///< items along a space-filling curve
    uint8_t* taken;     ///< per item: it belongs to a patch
    uint32_t* touching; ///< per item: length of its border with the patch being grown
    uint32_t* border;   ///< items that touch the patch and belong to none
    uint32_t border_count;
    uint32_t next; ///< place in the order: all items before it are taken
    stp_vec3d sum; ///< of the centres of the patch's items
} grower;

static stp_vec3d center_of(const grower* g, uint32_t item)
{
    const float* c = g->centers + 3 * (size_t)item;
    return (stp_vec3d){(double)c[0], (double)c[1], (double)c[2]};
}

/// The item of the border that joins next, which leaves it; NONE if there is none.
static uint32_t take_best(grower* g, uint32_t size)
{
    uint32_t best = NONE;
    double nearest = 0.0;
    stp_vec3d middle = stp_scaled(g->sum, 1.0 / size);
    for (uint32_t i = 0; i < g->border_count; ++i) {
        uint32_t item = g->border[i];
        stp_vec3d away = stp_subd(center_of(g, item), middle);
        double distance = stp_dotd(away, away);
        uint32_t own = g->touching[item], other = best != NONE ? g->touching[g->border[best]] : 0;
        bool better = own != other
                          ? own > other
                          : distance < nearest || (!(distance > nearest) && item < g->border[best]);
        if (best == NONE || better) {
            best = i;
            nearest = distance;
        }
    }
    if (best == NONE) {
        return NONE;
    }
    uint32_t item = g->border[best];
    g->border[best] = g->border[--g->border_count];
    return item;
}

/// The next item along the curve that is not taken; there must be one.
static uint32_t take_next(grower* g)
{
    while (g->taken[g->order[g->next]] != 0) {
        g->next += 1;
        assert(g->next < g->count);
    }
    return g->order[g->next];
}

static void join(grower* g, uint32_t item)
{
    const stp_patch_links* links = g->links;
    assert(g->taken[item] == 0);
    g->taken[item] = 1;
    g->sum = stp_addd(g->sum, center_of(g, item));
    for (uint32_t k = links->first[item]; k < links->first[item + 1]; ++k) {
        uint32_t other = links->neighbours[k];
        if (g->taken[other] == 0) {
            if (g->touching[other] == 0) {
                g->border[g->border_count++] = other;
            }
            g->touching[other] += links->weights[k];
        }
    }
}

/// Ends a patch. @return the item that it encloses most, where the next one begins, so that no
/// scraps stay behind; NONE if it has no border
static uint32_t end_patch(grower* g)
{
    uint32_t seed = NONE;
    for (uint32_t i = 0; i < g->border_count; ++i) {
        uint32_t other = g->border[i];
        if (seed == NONE || g->touching[other] > g->touching[seed] ||
            (g->touching[other] == g->touching[seed] && other < seed)) {
            seed = other;
        }
    }
    for (uint32_t i = 0; i < g->border_count; ++i) {
        g->touching[g->border[i]] = 0;
    }
    g->border_count = 0;
    g->sum = (stp_vec3d){0};
    return seed;
}

static void grow_all(grower* g, uint32_t maximum, uint32_t* members, uint32_t* ends,
                     uint32_t* patch_count)
{
    uint32_t seed = NONE;
    for (uint32_t done = 0; done < g->count;) {
        uint32_t begin = done, item = seed != NONE ? seed : take_next(g);
        while (item != NONE) {
            join(g, item);
            members[done++] = item;
            item = NONE;
            if (done - begin < maximum && done < g->count) {
                item = take_best(g, done - begin);
                item = item != NONE ? item : take_next(g);
            }
        }
        ends[(*patch_count)++] = done;
        seed = end_patch(g);
    }
}

stp_result stp_grow_patches(stp_context* context, const stp_patch_links* links,
                            const float* centers, uint32_t count, uint32_t maximum,
                            uint32_t* members, uint32_t* ends, uint32_t* patch_count)
{
    grower g = {.links = links, .centers = centers, .count = count};
    assert(maximum > 0);
    *patch_count = 0;
    g.touching = STP_NEW_ZEROED(context, uint32_t, (size_t)count + 1);
    g.border = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    g.order = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    g.taken = STP_NEW_ZEROED(context, uint8_t, (size_t)count + 1);
    bool good = g.touching != NULL && g.border != NULL && g.order != NULL && g.taken != NULL;
    stp_result result = good ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK && count > 0) {
        result = stp_sort_spatially(context, centers, count, g.order);
    }
    if (result == STP_OK) {
        grow_all(&g, maximum, members, ends, patch_count);
    }
    stp_free(context, g.touching);
    stp_free(context, g.border);
    stp_free(context, g.order);
    stp_free(context, g.taken);
    return result;
}

/// Both directions of each pair of items with a common edge, once for each such edge.
static size_t list_pairs(const uint32_t* indices, uint32_t triangle_count, const uint32_t* order,
                         const uint32_t* item_of, uint64_t* pairs)
{
    uint32_t corners = 3 * triangle_count;
    size_t count = 0;
    for (uint32_t i = 0, end; i < corners; i = end) {
        end = stp_edge_run(indices, order, i, corners);
        for (uint32_t k = i + 1; k < end; ++k) { // of many triangles, each with the one before
            uint64_t a = item_of[order[k - 1] / 3], b = item_of[order[k] / 3];
            if (a != b) {
                pairs[count++] = a << 32 | b;
                pairs[count++] = b << 32 | a;
            }
        }
    }
    return count;
}

stp_result stp_patch_links_make(stp_context* context, const uint32_t* indices,
                                uint32_t triangle_count, uint32_t vertex_count,
                                const uint32_t* item_of, uint32_t item_count,
                                stp_patch_links* links)
{
    *links = (stp_patch_links){0};
    size_t room = 6 * (size_t)triangle_count + 1;
    uint32_t* order = stp_sort_edges(context, indices, triangle_count, vertex_count);
    uint64_t* pairs = STP_NEW_ARRAY(context, uint64_t, room);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, room);
    links->first = STP_NEW_ZEROED(context, uint32_t, (size_t)item_count + 2);
    links->neighbours = STP_NEW_ARRAY(context, uint32_t, room);
    links->weights = STP_NEW_ARRAY(context, uint32_t, room);
    bool good = order != NULL && pairs != NULL && scratch != NULL && links->first != NULL &&
                links->neighbours != NULL && links->weights != NULL;
    if (good) {
        size_t count = list_pairs(indices, triangle_count, order, item_of, pairs);
        const uint64_t* sorted = stp_sort_u64(pairs, scratch, count, 0, 64);
        uint32_t made = 0, item = 0;
        for (size_t i = 0; i < count;) {
            uint64_t pair = sorted[i];
            for (; item < (uint32_t)(pair >> 32); ++item) {
                links->first[item + 1] = made;
            }
            links->neighbours[made] = (uint32_t)pair;
            links->weights[made] = 0;
            for (; i < count && sorted[i] == pair; ++i) {
                links->weights[made] += 1;
            }
            made += 1;
        }
        for (; item < item_count; ++item) {
            links->first[item + 1] = made;
        }
    }
    stp_free(context, order);
    stp_free(context, pairs);
    stp_free(context, scratch);
    return good ? STP_OK : stp_fail_memory(context);
}

void stp_patch_links_destroy(stp_context* context, stp_patch_links* links)
{
    stp_free(context, links->first);
    stp_free(context, links->neighbours);
    stp_free(context, links->weights);
    *links = (stp_patch_links){0};
}
