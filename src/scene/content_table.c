// SPDX-License-Identifier: MIT
#include "scene/content_table.h"

#include <assert.h>
#include <string.h>

// The entry of the content, or the free one where it belongs.
static stp_content_entry* find_entry(const stp_content_table* table, stp_hash hash)
{
    assert((table->size & (table->size - 1)) == 0 && table->count < table->size);
    size_t mask = table->size - 1;
    size_t slot = hash.low & mask;
    while (table->entries[slot].index != UINT32_MAX &&
           !stp_hash_equal(table->entries[slot].hash, hash)) {
        slot = (slot + 1) & mask;
    }
    return &table->entries[slot];
}

static stp_result grow_table(stp_context* context, stp_content_table* table)
{
    stp_content_table grown = {.size = table->size == 0 ? 64 : 2 * table->size,
                               .count = table->count};
    grown.entries = STP_NEW_ARRAY(context, stp_content_entry, grown.size);
    if (grown.entries == NULL) {
        return stp_fail_memory(context);
    }
    memset(grown.entries, 0xff, grown.size * sizeof(stp_content_entry));
    for (size_t i = 0; i < table->size; ++i) {
        const stp_content_entry* entry = &table->entries[i];
        if (entry->index != UINT32_MAX) {
            *find_entry(&grown, entry->hash) = *entry;
        }
    }
    stp_free(context, table->entries);
    *table = grown;
    return STP_OK;
}

stp_result stp_content_table_find(stp_context* context, stp_content_table* table, stp_hash hash,
                                  uint32_t index, uint32_t* found)
{
    assert(index != UINT32_MAX && "marks free entries");
    if (2 * (table->count + 1) > table->size) {
        stp_result result = grow_table(context, table);
        if (result != STP_OK) {
            return result;
        }
    }
    stp_content_entry* entry = find_entry(table, hash);
    if (entry->index == UINT32_MAX) {
        *entry = (stp_content_entry){.hash = hash, .index = index};
        table->count += 1;
    }
    *found = entry->index;
    return STP_OK;
}

void stp_content_table_destroy(stp_context* context, stp_content_table* table)
{
    stp_free(context, table->entries);
    *table = (stp_content_table){0};
}
