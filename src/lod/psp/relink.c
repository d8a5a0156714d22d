// SPDX-License-Identifier: MIT
#include "lod/psp/kd_tree.h"
#include "lod/psp/rounds.h"

#include <assert.h>
#include <string.h>

/// Allocates a block for this many links, and copies splats and states of another block.
static bool copy_block(const stp_psp_room* room, const stp_psp_block* from, size_t state_bytes,
                       size_t links, stp_psp_block* to)
{
    size_t splats = from->count * sizeof(*from->splats), states = from->count * state_bytes;
    to->memory =
        stp_psp_room_alloc(room, 1, splats + states + (from->count + 1 + links) * sizeof(uint32_t));
    if (to->memory == NULL) {
        return false;
    }
    memcpy(to->memory, from->memory, splats + states);
    to->splats = to->memory;
    to->states = (uint8_t*)to->memory + splats;
    to->begins = (uint32_t*)(void*)(to->states + states);
    to->links = to->begins + from->count + 1;
    to->count = from->count;
    to->first = 0;
    return true;
}

/// Adds links in both directions; duplicates are dropped when a piece is loaded.
static void link_nearest(stp_psp_block* b, const uint32_t* near, uint32_t k)
{
    uint32_t total = 0;
    memset(b->begins, 0, ((size_t)b->count + 1) * sizeof(uint32_t));
    for (size_t i = 0; i < (size_t)k * b->count; ++i) {
        if (near[i] != UINT32_MAX) {
            b->begins[i / k] += 1;
            b->begins[near[i]] += 1;
        }
    }
    for (uint32_t i = 0; i < b->count; ++i) {
        total += b->begins[i];
        b->begins[i] = total;
    }
    b->begins[b->count] = total;
    for (size_t i = (size_t)k * b->count; i-- > 0;) {
        if (near[i] != UINT32_MAX) {
            b->links[--b->begins[i / k]] = near[i];
            b->links[--b->begins[near[i]]] = (uint32_t)(i / k);
        }
    }
    assert(b->begins[0] == 0 && "as many links as were counted");
}

stp_result stp_psp_relink(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    stp_psp_block *b = &r->blocks[0], linked = {0};
    uint32_t count = b->count, k = r->shared.desc.neighbours;
    assert(r->block_count == 1 && count == r->live);
    if (2 * (size_t)k * count > UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT, "psp: %u splats have too many neighbours", count);
    }
    float* centers = STP_NEW_ARRAY(context, float, 3 * (size_t)count + 1);
    uint32_t* near = STP_NEW_ARRAY(context, uint32_t, (size_t)k * count + 1);
    const stp_psp_room* room = &r->rooms[STP_PSP_ROOM_LEFT];
    uint32_t* survivors = STP_PSP_NEW(room, uint32_t, (size_t)count + 1);
    bool made = centers != NULL && near != NULL && survivors != NULL &&
                copy_block(room, b, r->metric->state_bytes, 2 * (size_t)k * count, &linked);
    for (size_t i = 0; made && i < count; ++i) {
        memcpy(centers + 3 * i, &b->splats[i].ellipse.center, 3 * sizeof(float));
        survivors[i] = (uint32_t)i;
    }
    stp_result result = made ? stp_find_nearest_points(context, centers, count, k, near)
                             : stp_psp_storage_fail(&r->storage);
    if (result == STP_OK) {
        link_nearest(&linked, near, k);
        stp_psp_room_free(room, b->memory);
        stp_psp_room_free(room, r->survivors);
        *b = linked;
        r->survivors = survivors;
        r->slot_count = count;
        linked.memory = NULL;
        survivors = NULL;
    }
    stp_psp_room_free(room, linked.memory);
    stp_free(context, centers);
    stp_free(context, near);
    stp_psp_room_free(room, survivors);
    return result;
}
