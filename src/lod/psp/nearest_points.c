// SPDX-License-Identifier: MIT
#include "lod/psp/kd_tree.h"

#include <assert.h>

enum { GRAIN = 1024 };

typedef struct search {
    const stp_kd_tree* tree;
    uint32_t* neighbours;
    uint32_t k;
} search;

static float square_between(stp_vec3 a, stp_vec3 b)
{
    stp_vec3 d = stp_sub(a, b);
    return stp_dot(d, d);
}

void stp_list_neighbours(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                         uint32_t count, uint32_t k, uint32_t* neighbours)
{
    assert(count <= k && k <= STP_NEIGHBOURS_MAX);
    stp_vec3 p = stp_kd_at(tree, place);
    float squares[STP_NEIGHBOURS_MAX];
    for (uint32_t n = 0; n < count; ++n) {
        uint32_t point = stp_kd_index(tree, places[n]), at = n;
        float square = square_between(stp_kd_at(tree, places[n]), p);
        assert((n == 0 || squares[n - 1] <= square) && "nearest first");
        for (; at > 0 && squares[at - 1] == square && neighbours[at - 1] > point; --at) {
            neighbours[at] = neighbours[at - 1];
            squares[at] = squares[at - 1];
        }
        squares[at] = square;
        neighbours[at] = point;
    }
    for (uint32_t n = count; n < k; ++n) {
        neighbours[n] = UINT32_MAX;
    }
}

/// Runs in tree order, so that a point's data is already in the cache.
static void search_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const search* s = user;
    stp_kd_path path = {.leaf = UINT32_MAX};
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t place = (uint32_t)i, places[STP_NEIGHBOURS_MAX];
        uint32_t count = stp_kd_nearest(s->tree, &path, place, s->k, places);
        size_t point = stp_kd_index(s->tree, place);
        stp_list_neighbours(s->tree, place, places, count, s->k, s->neighbours + s->k * point);
    }
}

stp_result stp_find_nearest_points(stp_context* context, const float* positions, uint32_t count,
                                   uint32_t k, uint32_t* neighbours)
{
    assert(k > 0 && k <= STP_NEIGHBOURS_MAX);
    stp_kd_tree tree;
    stp_result result = stp_kd_tree_make(context, positions, count, 1.0f, &tree);
    if (result == STP_OK) {
        search s = {&tree, neighbours, k};
        stp_parallel_for(context, count, GRAIN, search_some, &s);
    }
    stp_kd_tree_destroy(context, &tree);
    return result;
}
