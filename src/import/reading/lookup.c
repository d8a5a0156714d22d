// SPDX-License-Identifier: MIT
#include "import/reading/lookup.h"

#include <assert.h>
#include <string.h>

// Tables are seeded with an address, so that a malicious file cannot cause collisions. The seed
// affects only where an entry is stored, not the result.
static stp_hash hash_key(const stp_lookup* lookup, const void* key, size_t size)
{
    return stp_hash_bytes((stp_hash){.low = (uint64_t)(uintptr_t)lookup}, key, size);
}

static stp_lookup_entry* find_slot(stp_lookup_entry* entries, size_t size, stp_hash hash)
{
    assert(size > 0 && (size & (size - 1)) == 0 && "a power of two");
    for (size_t slot = hash.low & (size - 1);; slot = (slot + 1) & (size - 1)) {
        stp_lookup_entry* entry = &entries[slot];
        if (entry->used == 0 || stp_hash_equal(entry->hash, hash)) {
            return entry;
        }
    }
}

static stp_result grow(stp_lookup* lookup)
{
    size_t size = lookup->size == 0 ? 64 : 2 * lookup->size;
    stp_lookup_entry* entries = STP_NEW_ZEROED(lookup->context, stp_lookup_entry, size);
    if (entries == NULL) {
        return stp_fail_memory(lookup->context);
    }
    for (size_t i = 0; i < lookup->size; ++i) {
        if (lookup->entries[i].used != 0) {
            *find_slot(entries, size, lookup->entries[i].hash) = lookup->entries[i];
        }
    }
    stp_free(lookup->context, lookup->entries);
    lookup->entries = entries;
    lookup->size = size;
    assert(2 * lookup->count <= size && "searches end at a free slot");
    return STP_OK;
}

stp_result stp_lookup_add(stp_lookup* lookup, const void* key, size_t size, uint32_t fresh,
                          uint32_t* value)
{
    if (2 * (lookup->count + 1) > lookup->size) {
        stp_result result = grow(lookup);
        if (result != STP_OK) {
            return result;
        }
    }
    stp_hash hash = hash_key(lookup, key, size);
    stp_lookup_entry* entry = find_slot(lookup->entries, lookup->size, hash);
    if (entry->used == 0) {
        *entry = (stp_lookup_entry){.hash = hash, .value = fresh, .used = 1};
        lookup->count += 1;
    }
    assert(2 * lookup->count <= lookup->size && "half of the slots are free");
    *value = entry->value;
    return STP_OK;
}

uint32_t stp_lookup_find(const stp_lookup* lookup, const void* key, size_t size, uint32_t missing)
{
    if (lookup->count == 0) {
        return missing;
    }
    assert(lookup->count < lookup->size && "searches end at a free slot");
    stp_lookup_entry* entry = find_slot(lookup->entries, lookup->size, hash_key(lookup, key, size));
    return entry->used != 0 ? entry->value : missing;
}

void stp_lookup_destroy(stp_lookup* lookup)
{
    stp_free(lookup->context, lookup->entries);
    *lookup = (stp_lookup){.context = lookup->context};
}
