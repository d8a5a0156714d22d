// SPDX-License-Identifier: MIT
#include "lod/psp/queue.h"

static bool is_before(const stp_psp_queue* q, uint32_t a, uint32_t b)
{
    const stp_psp_edge *x = &q->edges[a], *y = &q->edges[b];
    if (x->error != y->error) {
        return x->error < y->error;
    }
    if (x->weight != y->weight) {
        return x->weight < y->weight;
    }
    return x->left != y->left ? x->left < y->left : x->right < y->right;
}

static void put(stp_psp_queue* q, uint32_t place, uint32_t edge)
{
    q->heap[place] = edge;
    q->edges[edge].place = place;
}

static void move_up(stp_psp_queue* q, uint32_t place)
{
    uint32_t edge = q->heap[place];
    while (place > 0 && is_before(q, edge, q->heap[(place - 1) / 2])) {
        put(q, place, q->heap[(place - 1) / 2]);
        place = (place - 1) / 2;
    }
    put(q, place, edge);
}

static void move_down(stp_psp_queue* q, uint32_t place)
{
    uint32_t edge = q->heap[place];
    for (uint32_t child = 2 * place + 1; child < q->heap_count; child = 2 * place + 1) {
        if (child + 1 < q->heap_count && is_before(q, q->heap[child + 1], q->heap[child])) {
            child += 1;
        }
        if (!is_before(q, q->heap[child], edge)) {
            break;
        }
        put(q, place, q->heap[child]);
        place = child;
    }
    put(q, place, edge);
}

stp_result stp_psp_queue_add(stp_psp_queue* q, stp_psp_edge edge, uint32_t* number)
{
    if (q->edge_count >= UINT32_MAX / 2) {
        return stp_fail(q->context, STP_ERROR_LIMIT,
                        "progressive splats: more than %u pairs of neighbours", UINT32_MAX / 2);
    }
    if (q->edge_count == q->edge_capacity) {
        stp_psp_edge* edges = stp_grow_array(q->context, q->edges, &q->edge_capacity,
                                             (size_t)q->edge_count + 1, sizeof(*edges));
        if (edges == NULL) {
            return stp_fail_memory(q->context);
        }
        q->edges = edges;
    }
    if (q->heap_count == q->heap_capacity) {
        uint32_t* heap = stp_grow_array(q->context, q->heap, &q->heap_capacity,
                                        (size_t)q->heap_count + 1, sizeof(*heap));
        if (heap == NULL) {
            return stp_fail_memory(q->context);
        }
        q->heap = heap;
    }
    *number = q->edge_count++;
    q->edges[*number] = edge;
    put(q, q->heap_count++, *number);
    move_up(q, q->heap_count - 1);
    return STP_OK;
}

void stp_psp_queue_remove(stp_psp_queue* q, uint32_t number)
{
    uint32_t place = q->edges[number].place;
    if (place == UINT32_MAX) {
        return;
    }
    q->edges[number].place = UINT32_MAX;
    uint32_t last = q->heap[--q->heap_count];
    if (last != number) {
        put(q, place, last);
        move_up(q, place);
        move_down(q, q->edges[last].place);
    }
}

uint32_t stp_psp_queue_take(stp_psp_queue* q)
{
    if (q->heap_count == 0) {
        return UINT32_MAX;
    }
    uint32_t first = q->heap[0];
    stp_psp_queue_remove(q, first);
    return first;
}

void stp_psp_queue_destroy(stp_psp_queue* q)
{
    stp_free(q->context, q->edges);
    stp_free(q->context, q->heap);
    *q = (stp_psp_queue){.context = q->context};
}
