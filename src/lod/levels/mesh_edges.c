// SPDX-License-Identifier: MIT
#include "lod/levels/mesh_edges.h"

#include "base/core/sort.h"

#include <assert.h>

uint32_t* stp_sort_edges(stp_context* context, const uint32_t* indices, uint32_t triangle_count,
                         uint32_t vertex_count)
{
    assert(triangle_count <= UINT32_MAX / 3);
    uint32_t count = 3 * triangle_count, ends[2];
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, (size_t)count + 1);
    uint64_t* scratch = STP_NEW_ARRAY(context, uint64_t, (size_t)count + 1);
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    if (items != NULL && scratch != NULL && order != NULL) {
        unsigned bits = stp_bit_width(vertex_count);
        for (uint32_t i = 0; i < count; ++i) {
            stp_edge_ends(indices, i, ends);
            items[i] = (uint64_t)ends[1] << 32 | i;
        }
        uint64_t* sorted = stp_sort_u64(items, scratch, count, 32, bits);
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t corner = (uint32_t)sorted[i];
            stp_edge_ends(indices, corner, ends);
            sorted[i] = (uint64_t)ends[0] << 32 | corner;
        }
        uint64_t* again = stp_sort_u64(sorted, sorted == items ? scratch : items, count, 32, bits);
        for (uint32_t i = 0; i < count; ++i) {
            order[i] = (uint32_t)again[i];
        }
    } else {
        stp_free(context, order);
        order = NULL;
    }
    stp_free(context, items);
    stp_free(context, scratch);
    return order;
}

uint32_t stp_edge_run(const uint32_t* indices, const uint32_t* order, uint32_t begin,
                      uint32_t count)
{
    uint32_t first[2], other[2], end = begin + 1;
    stp_edge_ends(indices, order[begin], first);
    for (; end < count; ++end) {
        stp_edge_ends(indices, order[end], other);
        if (other[0] != first[0] || other[1] != first[1]) {
            break;
        }
    }
    return end;
}
