// SPDX-License-Identifier: MIT
#include "select/visibility.h"

#include "base/core/context.h"
#include "select/visibility_internal.h"

#include <assert.h>
#include <string.h>

stp_result stp_visibility_create(stp_context* context, const stp_store* store,
                                 stp_visibility** visibility)
{
    stp_visibility* v = STP_NEW_ZEROED(context, stp_visibility, 1);
    *visibility = v;
    if (v == NULL) {
        return stp_fail_memory(context);
    }
    *v = (stp_visibility){
        .context = context, .store = store, .directory = stp_store_get_directory(store)};
    return STP_OK;
}

static void drop_mixed(stp_visibility* v)
{
    for (size_t i = 0; i < v->mixed_count; ++i) {
        stp_free(v->context, v->mixed[i].slots);
    }
    v->mixed_count = 0;
    v->first_free = 0;
}

void stp_visibility_destroy(stp_visibility* v)
{
    if (v != NULL) {
        drop_mixed(v);
        stp_free(v->context, v->mixed);
        stp_free(v->context, v->has_parts);
        stp_free(v->context, v->marks);
        stp_free(v->context, v);
    }
}

void stp_visibility_reset(stp_visibility* v, stp_show show)
{
    assert(show <= STP_SHOW_NOT && "a uniform state");
    drop_mixed(v);
    v->root = (uint32_t)show;
    v->version += 1;
}

uint64_t stp_visibility_version(const stp_visibility* v)
{
    return v->version;
}

uint32_t stp_visibility_root(const stp_visibility* v)
{
    return v->root;
}

uint32_t stp_visibility_below(const stp_visibility* v, uint32_t state, uint32_t slot)
{
    assert(stp_show_of(state) == STP_SHOW_MIXED && state - STP_SHOW_MIXED < v->mixed_count);
    assert(v->mixed[state - STP_SHOW_MIXED].slots != NULL && "the state was freed");
    assert(slot < v->mixed[state - STP_SHOW_MIXED].count);
    return v->mixed[state - STP_SHOW_MIXED].slots[slot];
}

/// Finds an index for a new mixed state. @return false if out of memory (logged)
static bool find_free(stp_visibility* v, uint32_t* index)
{
    if (v->first_free > 0) {
        *index = v->first_free - 1;
        assert(*index < v->mixed_count && v->mixed[*index].slots == NULL);
        v->first_free = v->mixed[*index].next_free;
        return true;
    }
    if (v->mixed_count >= UINT32_MAX - STP_SHOW_MIXED ||
        !STP_MAKE_ROOM(v->context, v->mixed, v->mixed_capacity, v->mixed_count + 1)) {
        (void)stp_fail_memory(v->context);
        return false;
    }
    *index = (uint32_t)v->mixed_count++;
    return true;
}

stp_result stp_visibility_split(stp_visibility* v, uint32_t node, uint32_t state, uint32_t* split)
{
    const stp_store_node* n = &v->directory->nodes[node];
    size_t count = (size_t)n->edge_count + n->part_count;
    assert(stp_show_of(state) != STP_SHOW_MIXED && "a uniform state");
    assert(count > 0 && "the node has a slot that differs");
    uint32_t* slots = STP_NEW_ARRAY(v->context, uint32_t, count);
    if (slots == NULL) {
        return stp_fail_memory(v->context);
    }
    uint32_t index;
    if (!find_free(v, &index)) {
        stp_free(v->context, slots);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    v->mixed[index] = (stp_visibility_mixed){.slots = slots, .count = (uint32_t)count};
    for (size_t i = 0; i < count; ++i) {
        slots[i] = state;
    }
    *split = index + STP_SHOW_MIXED;
    return STP_OK;
}

void stp_visibility_merge(stp_visibility* v, uint32_t state)
{
    if (stp_show_of(state) != STP_SHOW_MIXED) {
        return;
    }
    stp_visibility_mixed* m = &v->mixed[state - STP_SHOW_MIXED];
    assert(state - STP_SHOW_MIXED < v->mixed_count && m->slots != NULL && "freed once");
    for (uint32_t i = 0; i < m->count; ++i) {
        stp_visibility_merge(v, m->slots[i]); // as deep as the recursion that built it
    }
    stp_free(v->context, m->slots);
    *m = (stp_visibility_mixed){.next_free = v->first_free};
    v->first_free = state - STP_SHOW_MIXED + 1;
}
