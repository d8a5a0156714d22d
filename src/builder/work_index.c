// SPDX-License-Identifier: MIT
#include "builder/work_internal.h"

#include <assert.h>

enum { FIRST_SLOTS = 256 };

void stp_work_index_destroy(stp_context* context, stp_work_index* index)
{
    stp_free(context, index->entries);
    stp_free(context, index->slots);
    *index = (stp_work_index){0};
}

// The slot of the key, or the free slot where it belongs.
static size_t slot_of(const stp_work_index* index, stp_hash key)
{
    assert(index->slot_count != 0 && (index->slot_count & (index->slot_count - 1)) == 0);
    assert(index->count < index->slot_count && "a free slot ends the search");
    size_t mask = index->slot_count - 1;
    size_t slot = (size_t)(key.low ^ key.high) & mask;
    while (index->slots[slot] != 0 &&
           !stp_hash_equal(index->entries[index->slots[slot] - 1].key, key)) {
        slot = (slot + 1) & mask;
    }
    return slot;
}

stp_work_entry* stp_work_index_find(const stp_work_index* index, stp_hash key)
{
    if (index->slot_count == 0) {
        return NULL;
    }
    uint32_t found = index->slots[slot_of(index, key)];
    return found != 0 ? &index->entries[found - 1] : NULL;
}

// Doubles the slots, so that at least half are free.
static bool grow_slots(stp_context* context, stp_work_index* index)
{
    size_t count = index->slot_count != 0 ? 2 * index->slot_count : FIRST_SLOTS;
    uint32_t* slots = STP_NEW_ZEROED(context, uint32_t, count);
    if (slots == NULL) {
        return false;
    }
    stp_free(context, index->slots);
    index->slots = slots;
    index->slot_count = count;
    for (size_t i = 0; i < index->count; ++i) {
        index->slots[slot_of(index, index->entries[i].key)] = (uint32_t)i + 1;
    }
    return true;
}

stp_work_entry* stp_work_index_add(stp_context* context, stp_work_index* index, stp_hash key)
{
    stp_work_entry* found = stp_work_index_find(index, key);
    if (found != NULL) {
        return found;
    }
    if (index->count >= UINT32_MAX - 1 ||
        (2 * (index->count + 1) > index->slot_count && !grow_slots(context, index))) {
        return NULL;
    }
    if (!STP_MAKE_ROOM(context, index->entries, index->capacity, index->count + 1)) {
        return NULL;
    }
    assert(2 * (index->count + 1) <= index->slot_count && index->count < index->capacity);
    index->entries[index->count] = (stp_work_entry){.key = key, .state = STP_WORK_ABSENT};
    index->slots[slot_of(index, key)] = (uint32_t)index->count + 1;
    index->count += 1;
    return &index->entries[index->count - 1];
}
