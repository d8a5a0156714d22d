// SPDX-License-Identifier: MIT
// A priority queue of merges: a binary heap that knows where each of them is.
#pragma once

#include "base/context.h"

/// A merge that is possible. The one of least error comes first; of equal ones that of least weight, then of least numbers,
/// so that the order is the same everywhere, and a plane is merged evenly.
typedef struct stp_psp_edge {
    double error, weight;
    uint32_t left, right; ///< splats
    uint32_t place;       ///< in the heap; UINT32_MAX: not in it
} stp_psp_edge;

typedef struct stp_psp_queue {
    stp_context* context;
    stp_psp_edge* edges;
    uint32_t* heap; ///< of edges
    uint32_t edge_count, heap_count;
    size_t edge_capacity, heap_capacity;
} stp_psp_queue;

/// Adds an edge, which keeps its number. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_psp_queue_add(stp_psp_queue* queue, stp_psp_edge edge,
                                          uint32_t* number);
/// Takes the first one out. @return its number; UINT32_MAX: there is none
uint32_t stp_psp_queue_take(stp_psp_queue* queue);
/// Takes out one that is no longer possible; nothing if it is not in the heap.
void stp_psp_queue_remove(stp_psp_queue* queue, uint32_t number);
void stp_psp_queue_destroy(stp_psp_queue* queue);
