// SPDX-License-Identifier: MIT
// Content keys of splat sets and meshes. A build finds the results of a previous build by them.
#include "store/file/block_table.h"
#include "store/file/tables.h"

#include <assert.h>
#include <string.h>

// Hash table with open addressing: sets first, then meshes. A slot holds record index + 1.
typedef struct stp_store_key_table {
    const stp_store_key* keys;
    uint32_t set_count, mesh_count;
    uint32_t *set_slots, *mesh_slots;
    size_t set_mask, mesh_mask;
} stp_store_key_table;

static bool is_none(stp_hash key)
{
    return key.low == 0 && key.high == 0;
}

// @return the slots, or NULL if memory runs out
static uint32_t* make_slots(stp_context* context, const stp_store_key* keys, uint32_t count,
                            size_t* mask)
{
    size_t size = 16;
    while (size < 2 * (size_t)count) {
        size *= 2;
    }
    *mask = size - 1;
    assert(size > count && (size & *mask) == 0 && "probing meets an empty slot");
    uint32_t* slots = STP_NEW_ZEROED(context, uint32_t, size);
    for (uint32_t i = 0; slots != NULL && i < count; ++i) {
        size_t slot = keys[i].hash.low & *mask;
        while (slots[slot] != 0) {
            slot = (slot + 1) & *mask;
        }
        slots[slot] = is_none(keys[i].hash) ? slots[slot] : i + 1;
    }
    return slots;
}

static uint32_t find_slot(const stp_store_key* keys, const uint32_t* slots, size_t mask,
                          stp_hash key)
{
    if (slots == NULL || is_none(key)) {
        return STP_STORE_NONE;
    }
    for (size_t slot = key.low & mask; slots[slot] != 0; slot = (slot + 1) & mask) {
        if (stp_hash_equal(keys[slots[slot] - 1].hash, key)) {
            return slots[slot] - 1;
        }
    }
    return STP_STORE_NONE;
}

static stp_result make_table(stp_store* store)
{
    if (store->keys != NULL) {
        return STP_OK;
    }
    const stp_store_directory* d = &store->directory;
    stp_store_text text = {.context = store->context};
    stp_result result = STP_OK;
    if (store->tables[STP_SECTION_KEYS] == NULL && !store->only_summary) {
        result = stp_store_read_table(store, STP_SECTION_KEYS, &text);
    }
    uint32_t count = store->counts[STP_SECTION_KEYS];
    if (result == STP_OK && count != 0 && count != (uint64_t)d->set_count + d->mesh_count) {
        result = stp_fail(store->context, STP_ERROR_FORMAT,
                          "%s: has %u keys for %u splat sets and %u meshes", store->path, count,
                          d->set_count, d->mesh_count);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_store_key_table* table = STP_NEW_ZEROED(store->context, stp_store_key_table, 1);
    store->keys = table;
    if (table != NULL && count != 0) {
        table->keys = store->tables[STP_SECTION_KEYS];
        table->set_slots = make_slots(store->context, table->keys, d->set_count, &table->set_mask);
        table->mesh_slots = make_slots(store->context, table->keys + d->set_count, d->mesh_count,
                                       &table->mesh_mask);
    }
    if (table == NULL || (count != 0 && (table->set_slots == NULL || table->mesh_slots == NULL))) {
        stp_store_free_keys(store);
        return stp_fail_memory(store->context);
    }
    return STP_OK;
}

void stp_store_free_keys(stp_store* store)
{
    if (store->keys != NULL) {
        stp_free(store->context, store->keys->set_slots);
        stp_free(store->context, store->keys->mesh_slots);
        stp_free(store->context, store->keys);
    }
    store->keys = NULL;
}

stp_result stp_store_find_splat_set_by_key(stp_store* store, stp_hash key,
                                           stp_store_stored_splat_set* found)
{
    *found = (stp_store_stored_splat_set){.index = STP_STORE_NONE};
    stp_result result = make_table(store);
    if (result != STP_OK) {
        return result;
    }
    const stp_store_key_table* t = store->keys;
    uint32_t index = find_slot(t->keys, t->set_slots, t->set_mask, key);
    if (index == STP_STORE_NONE) {
        return STP_OK;
    }
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    assert(index < store->directory.set_count);
    found->splats = &sets[index].splats;
    found->index = index;
    return STP_OK;
}

stp_result stp_store_find_mesh_by_key(stp_store* store, stp_hash key, stp_store_stored_mesh* found)
{
    *found = (stp_store_stored_mesh){.index = STP_STORE_NONE};
    stp_result result = make_table(store);
    if (result != STP_OK) {
        return result;
    }
    const stp_store_key_table* t = store->keys;
    const stp_store_key* keys = t->keys != NULL ? t->keys + store->directory.set_count : NULL;
    uint32_t index = find_slot(keys, t->mesh_slots, t->mesh_mask, key);
    if (index == STP_STORE_NONE) {
        return STP_OK;
    }
    const stp_store_mesh_record* meshes = store->tables[STP_SECTION_MESHES];
    assert(index < store->directory.mesh_count);
    const stp_store_block* block = stp_store_block_at(store, meshes[index].block);
    const unsigned char* bytes = NULL;
    result = stp_store_verify_block(store, block, &bytes);
    if (result == STP_OK) {
        found->index = index;
        found->mesh = &meshes[index].mesh;
        found->present = meshes[index].present;
        found->block = bytes;
        found->size = (size_t)block->size;
    }
    return result;
}
