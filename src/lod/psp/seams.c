// SPDX-License-Identifier: MIT
// Links across the seams of the first round, and slots from round to round.
#include "base/core/sort.h"
#include "lod/psp/rounds.h"

#include <assert.h>

enum { GRAIN = 1 << 16 }; ///< slots per piece of a parallel loop

typedef struct numbering {
    stp_psp_rounds* rounds;
    uint32_t* slots; ///< slots, by splat number
    size_t* starts;  ///< per block, where the targets of its links across seams start
    uint64_t* reverse;
} numbering;

static void number_slots(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    stp_psp_rounds_release(n->rounds, begin / GRAIN);
    for (size_t slot = begin; slot < end; ++slot) {
        assert(n->rounds->order[slot].index < n->rounds->live);
        n->slots[n->rounds->order[slot].index] = (uint32_t)slot;
    }
}

static void number_survivors(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    stp_psp_rounds_release(n->rounds, begin / GRAIN);
    for (size_t i = begin; i < end; ++i) {
        assert(n->rounds->survivors[i] < n->rounds->live);
        n->rounds->survivors[i] = n->slots[n->rounds->survivors[i]];
    }
}

static void reverse_links(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &n->rounds->blocks[i];
        stp_psp_rounds_release(n->rounds, i);
        size_t at = n->starts[i];
        for (uint32_t s = 0; s < b->count; ++s) {
            for (uint32_t l = b->begins[s]; l < b->begins[s + 1]; ++l) {
                if ((b->links[l] & STP_PSP_OUTSIDE) != 0) {
                    uint32_t to = n->rounds->survivors[b->links[l] & ~STP_PSP_OUTSIDE];
                    n->reverse[at++] = (uint64_t)to << 32 | n->slots[b->first + s];
                }
            }
        }
        assert((i + 1 == n->rounds->block_count || at == n->starts[i + 1]) && "as counted");
    }
}

static void count_links(size_t begin, size_t end, uint32_t worker, void* user)
{
    const numbering* n = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_psp_block* b = &n->rounds->blocks[i];
        stp_psp_rounds_release(n->rounds, i);
        n->starts[i] = 0;
        for (uint32_t l = 0; l < b->begins[b->count]; ++l) {
            n->starts[i] += (b->links[l] & STP_PSP_OUTSIDE) != 0 ? 1 : 0;
        }
    }
}

/// After the first round: a point may be among the nearest neighbours of a point across a seam, and
/// then only the other one lists the link. Adds the reverse links.
static bool turn_links(numbering* n)
{
    stp_psp_rounds* r = n->rounds;
    stp_context* context = r->shared.context;
    size_t total = 0;
    n->starts = STP_NEW_ARRAY(context, size_t, (size_t)r->block_count + 1);
    if (n->starts == NULL) {
        return false;
    }
    stp_parallel_for(context, r->block_count, 1, count_links, n);
    for (uint32_t i = 0; i < r->block_count; ++i) {
        size_t count = n->starts[i];
        n->starts[i] = total;
        total += count;
    }
    const stp_psp_room* room = &r->rooms[STP_PSP_ROOM_WORK];
    uint64_t* scratch = STP_PSP_NEW(room, uint64_t, total + 1);
    uint64_t* sorted = NULL;
    n->reverse = STP_PSP_NEW(room, uint64_t, total + 1);
    if (n->reverse != NULL && scratch != NULL) {
        stp_parallel_for(context, r->block_count, 1, reverse_links, n);
        sorted = stp_parallel_sort_u64(context, n->reverse, scratch, total, 32, 31);
    }
    stp_psp_room_free(room, sorted != scratch ? scratch : NULL);
    stp_psp_room_free(room, sorted != n->reverse ? n->reverse : NULL);
    stp_free(context, n->starts);
    r->reverse = sorted;
    r->reverse_count = sorted != NULL ? total : 0;
    return sorted != NULL;
}

stp_result stp_psp_renumber(stp_psp_rounds* r)
{
    stp_context* context = r->shared.context;
    const stp_psp_room* room = &r->rooms[STP_PSP_ROOM_WORK];
    assert(r->round > 0 && r->live < STP_PSP_OUTSIDE && "slots leave the flag's bit free");
    numbering n = {.rounds = r, .slots = STP_PSP_NEW(room, uint32_t, (size_t)r->live + 1)};
    bool made = n.slots != NULL;
    if (made) {
        stp_parallel_for(context, r->live, GRAIN, number_slots, &n);
        stp_parallel_for(context, r->slot_count, GRAIN, number_survivors, &n);
        made = r->round != 1 || r->block_count == 1 || turn_links(&n);
    }
    stp_psp_room_free(room, n.slots);
    return made ? STP_OK : stp_psp_storage_fail(&r->storage);
}
