// SPDX-License-Identifier: MIT
#include "lod/levels/mesh_edges.h"

#include <assert.h>
#include <stdlib.h>

enum { FEW = 24 }; ///< edges of a vertex that are sorted by insertion

static int compare_items(const void* left, const void* right)
{
    uint64_t a = *(const uint64_t*)left, b = *(const uint64_t*)right;
    return a < b ? -1 : a > b ? 1 : 0;
}

/// Sorts the items of a vertex: few, but for the hub of a fan.
static void sort_items(uint64_t* items, uint32_t count)
{
    if (count > FEW) {
        qsort(items, count, sizeof(*items), compare_items);
        return;
    }
    for (uint32_t i = 1; i < count; ++i) {
        uint64_t item = items[i];
        uint32_t at = i;
        for (; at > 0 && items[at - 1] > item; --at) {
            items[at] = items[at - 1];
        }
        items[at] = item;
    }
}

/// Distributes the corners by the smaller ends of their edges. `starts`: zero; receives the end of
/// each vertex. `items`: receives the larger end and the corner.
static void distribute(const uint32_t* indices, uint32_t count, uint32_t vertex_count,
                       uint32_t* starts, uint64_t* items)
{
    uint32_t ends[2], sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
        stp_edge_ends(indices, i, ends);
        assert(ends[1] < vertex_count);
        starts[ends[0]] += 1;
    }
    for (uint32_t v = 0; v < vertex_count; ++v) {
        uint32_t own = starts[v];
        starts[v] = sum;
        sum += own;
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_edge_ends(indices, i, ends);
        items[starts[ends[0]]++] = (uint64_t)ends[1] << 32 | i;
    }
}

bool stp_mesh_edges_make(stp_context* context, const uint32_t* indices, uint32_t triangle_count,
                         uint32_t vertex_count, stp_mesh_edges* edges)
{
    assert(triangle_count <= UINT32_MAX / 3);
    uint32_t count = 3 * triangle_count;
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, (size_t)count + 1);
    uint32_t* starts = STP_NEW_ZEROED(context, uint32_t, (size_t)vertex_count + 1);
    *edges = (stp_mesh_edges){.ends = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1),
                              .corners = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1)};
    bool good = items != NULL && starts != NULL && edges->ends != NULL && edges->corners != NULL;
    if (good) {
        distribute(indices, count, vertex_count, starts, items);
    }
    for (uint32_t v = 0, begin = 0; v < vertex_count && good; ++v) {
        uint32_t end = starts[v];
        sort_items(items + begin, end - begin);
        for (uint32_t i = begin; i < end; ++i) {
            edges->corners[i] = (uint32_t)items[i];
            if (i == begin || items[i] >> 32 != items[i - 1] >> 32) {
                edges->count += 1;
            }
            edges->ends[edges->count - 1] = i + 1;
        }
        begin = end;
    }
    stp_free(context, items);
    stp_free(context, starts);
    return good;
}

void stp_mesh_edges_destroy(stp_context* context, stp_mesh_edges* edges)
{
    stp_free(context, edges->ends);
    stp_free(context, edges->corners);
    *edges = (stp_mesh_edges){0};
}
