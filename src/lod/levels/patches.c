// SPDX-License-Identifier: MIT
#include "lod/levels/patches.h"

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
    uint32_t best = NONE, most = 0;
    double nearest = 0.0;
    stp_vec3d middle = stp_scaled(g->sum, 1.0 / size);
    for (uint32_t i = 0; i < g->border_count; ++i) {
        uint32_t item = g->border[i], own = g->touching[item];
        if (own < most) {
            continue;
        }
        stp_vec3d away = stp_subd(center_of(g, item), middle);
        double distance = stp_dotd(away, away);
        if (own > most || distance < nearest || (!(distance > nearest) && item < g->border[best])) {
            best = i;
            most = own;
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

/// The items of two triangles that follow each other at an edge, of many each with the one before.
/// @return whether they differ
static bool find_pair(const stp_mesh_edges* edges, const uint32_t* item_of, uint32_t corner,
                      uint32_t pair[2])
{
    pair[0] = item_of[edges->corners[corner - 1] / 3];
    pair[1] = item_of[edges->corners[corner] / 3];
    return pair[0] != pair[1];
}

/// Counts the neighbours of each item, once for each common edge. `starts`: zero; receives where
/// lists of them begin. @return neighbours of all items
static uint32_t count_neighbours(const stp_mesh_edges* edges, const uint32_t* item_of,
                                 uint32_t item_count, uint32_t* starts)
{
    uint32_t pair[2], sum = 0;
    for (uint32_t e = 0, i = 0; e < edges->count; ++e) {
        for (i += 1; i < edges->ends[e]; ++i) {
            if (find_pair(edges, item_of, i, pair)) {
                starts[pair[0]] += 1;
                starts[pair[1]] += 1;
            }
        }
    }
    for (uint32_t item = 0; item < item_count; ++item) {
        uint32_t own = starts[item];
        starts[item] = sum;
        sum += own;
    }
    return sum;
}

/// Lists the neighbours. `places`: where lists begin; receives their ends.
static void list_neighbours(const stp_mesh_edges* edges, const uint32_t* item_of, uint32_t* places,
                            uint32_t* neighbours)
{
    uint32_t pair[2];
    for (uint32_t e = 0, i = 0; e < edges->count; ++e) {
        for (i += 1; i < edges->ends[e]; ++i) {
            if (find_pair(edges, item_of, i, pair)) {
                neighbours[places[pair[0]]++] = pair[1];
                neighbours[places[pair[1]]++] = pair[0];
            }
        }
    }
}

/// Sorts the lists of all items: walking them in ascending order visits each one's own neighbours
/// in ascending order. `ends`: of the lists; `places`: room for as many.
static void sort_neighbours(uint32_t item_count, const uint32_t* ends, const uint32_t* neighbours,
                            uint32_t* places, uint32_t* sorted)
{
    for (uint32_t item = 0; item < item_count; ++item) {
        places[item] = item > 0 ? ends[item - 1] : 0;
    }
    for (uint32_t item = 0, i = 0; item < item_count; ++item) {
        for (; i < ends[item]; ++i) {
            sorted[places[neighbours[i]]++] = item;
        }
    }
}

/// Joins equal neighbours of the sorted lists, in place. `ends`: of the lists.
static void join_neighbours(uint32_t item_count, const uint32_t* ends, stp_patch_links* links)
{
    uint32_t made = 0;
    for (uint32_t item = 0, i = 0; item < item_count; ++item) {
        links->first[item] = made;
        while (i < ends[item]) {
            uint32_t neighbour = links->neighbours[i], begin = i;
            while (i < ends[item] && links->neighbours[i] == neighbour) {
                i += 1;
            }
            links->neighbours[made] = neighbour;
            links->weights[made++] = i - begin;
        }
    }
    links->first[item_count] = made;
}

stp_result stp_patch_links_make(stp_context* context, const uint32_t* indices,
                                uint32_t triangle_count, uint32_t vertex_count,
                                const uint32_t* item_of, uint32_t item_count,
                                stp_patch_links* links)
{
    stp_mesh_edges edges;
    bool good = stp_mesh_edges_make(context, indices, triangle_count, vertex_count, &edges);
    uint32_t* ends = STP_NEW_ZEROED(context, uint32_t, (size_t)item_count + 1);
    *links = (stp_patch_links){.first = STP_NEW_ARRAY(context, uint32_t, (size_t)item_count + 1)};
    good = good && ends != NULL && links->first != NULL;
    if (good) {
        size_t count = count_neighbours(&edges, item_of, item_count, ends);
        links->neighbours = STP_NEW_ARRAY(context, uint32_t, count + 1);
        links->weights = STP_NEW_ARRAY(context, uint32_t, count + 1);
        good = links->neighbours != NULL && links->weights != NULL;
    }
    if (good) {
        // the lists are in the place of the weights, until they are sorted
        list_neighbours(&edges, item_of, ends, links->weights);
        sort_neighbours(item_count, ends, links->weights, links->first, links->neighbours);
        join_neighbours(item_count, ends, links);
    }
    stp_mesh_edges_destroy(context, &edges);
    stp_free(context, ends);
    return good ? STP_OK : stp_fail_memory(context);
}

void stp_patch_links_destroy(stp_context* context, stp_patch_links* links)
{
    stp_free(context, links->first);
    stp_free(context, links->neighbours);
    stp_free(context, links->weights);
    *links = (stp_patch_links){0};
}
