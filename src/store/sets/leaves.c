// SPDX-License-Identifier: MIT
// Leaves of sets: verified on first use, with the tree over them.
#include "store/file/block_table.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

_Static_assert(sizeof(stp_splat_leaf) == STP_STORE_LEAF_BYTES,
               "leaves have the same layout in files and in memory");

static stp_store_leaves_record* record_of(const stp_store* store, uint32_t set)
{
    stp_store_leaves_record* records = store->tables[STP_SECTION_LEAVES];
    return set < store->counts[STP_SECTION_LEAVES] ? &records[set] : NULL;
}

uint32_t stp_store_leaf_count(const stp_store* store, uint32_t set)
{
    const stp_store_leaves_record* record = record_of(store, set);
    return record != NULL ? record->leaf_count : 0;
}

const stp_store_block* stp_store_leaves_block(const stp_store* store, uint32_t set)
{
    return stp_store_leaf_count(store, set) > 0
               ? stp_store_block_at(store, record_of(store, set)->block)
               : NULL;
}

uint64_t stp_store_leaves_bytes(uint32_t leaf_count)
{
    return STP_STORE_LEAF_BYTES * (uint64_t)leaf_count +
           sizeof(stp_leaf_node) * (uint64_t)stp_leaf_tree_max_nodes(leaf_count);
}

const char* stp_store_open_leaves(const stp_store* store, uint32_t set, void* memory,
                                  stp_store_leaves* leaves)
{
    assert((uintptr_t)memory % _Alignof(stp_leaf_node) == 0);
    uint32_t count = stp_store_leaf_count(store, set);
    const stp_splat_leaf* first = memory;
    const char* fault =
        stp_splat_leaves_fault(stp_store_describe_splat_set(store, set), first, count);
    if (fault == NULL) {
        stp_leaf_node* nodes =
            (stp_leaf_node*)(void*)((unsigned char*)memory + STP_STORE_LEAF_BYTES * (size_t)count);
        *leaves = (stp_store_leaves){.leaf_count = count, .leaves = first, .nodes = nodes};
        leaves->node_count = stp_leaf_tree_make(first, count, nodes);
    }
    return fault;
}

void stp_store_publish_leaves(const stp_store* store, uint32_t set, const stp_store_leaves* leaves)
{
    assert(leaves == NULL || leaves->leaf_count == stp_store_leaf_count(store, set));
    record_of(store, set)->leaves = leaves != NULL ? *leaves : (stp_store_leaves){0};
}

stp_result stp_store_get_leaves(stp_store* store, uint32_t set, stp_store_leaves* leaves)
{
    stp_store_leaves_record* record = record_of(store, set);
    *leaves = (stp_store_leaves){0};
    const stp_store_block* block = stp_store_leaves_block(store, set);
    if (block == NULL) {
        return STP_OK;
    }
    bool here = store->residency == NULL && stp_store_is_block_here(store, block);
    if (record->leaves.leaf_count == 0 && here) {
        const unsigned char* bytes = NULL;
        stp_result result = stp_store_verify_block(store, block, &bytes);
        if (result != STP_OK) {
            return result;
        }
        void* memory = stp_alloc(store->context, stp_store_leaves_bytes(record->leaf_count));
        if (memory == NULL) {
            return stp_fail_memory(store->context);
        }
        assert(block->size == STP_STORE_LEAF_BYTES * (uint64_t)record->leaf_count);
        memcpy(memory, bytes, (size_t)block->size);
        const char* fault = stp_store_open_leaves(store, set, memory, &record->leaves);
        if (fault != NULL) {
            stp_free(store->context, memory);
            return stp_fail(store->context, STP_ERROR_FORMAT, "%s: splat set %u: %s", store->path,
                            set, fault);
        }
        record->memory = memory;
    }
    *leaves = record->leaves;
    return STP_OK;
}

void stp_store_release_leaves(stp_store* store)
{
    for (uint32_t i = 0; i < store->counts[STP_SECTION_LEAVES]; ++i) {
        stp_store_leaves_record* record = record_of(store, i);
        if (record->memory != NULL) {
            stp_free(store->context, record->memory);
            record->memory = NULL;
            record->leaves = (stp_store_leaves){0};
        }
    }
}
