// SPDX-License-Identifier: MIT
// The block table, and the records that own blocks.
#include "store/file/block_table.h"

#include "store/bytes/chunks.h"
#include "store/bytes/deflate.h"

#include <assert.h>
#include <string.h>

const stp_store_block* stp_store_block_at(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_BLOCKS]);
    const stp_store_block* blocks = store->tables[STP_SECTION_BLOCKS];
    return &blocks[index];
}

bool stp_store_is_block_here(const stp_store* store, const stp_store_block* block)
{
    assert(block->offset <= store->file_bytes && block->size <= store->file_bytes - block->offset);
    return block->offset + block->size <= store->file.size;
}

stp_result stp_store_fail_block(const stp_store* store, const stp_store_block* block,
                                const char* what)
{
    if (what == stp_store_no_memory) {
        return stp_fail_memory(store->context);
    }
    if (!stp_store_is_block_here(store, block)) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends before the block at %llu does", store->path,
                        (unsigned long long)block->offset);
    }
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: the %s of the block at %llu is wrong",
                    store->path, what, (unsigned long long)block->offset);
}

stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                  const unsigned char** bytes)
{
    bool here = stp_store_is_block_here(store, block);
    *bytes = store->file.bytes + (here ? block->offset : 0);
    if (!here || stp_store_crc(0, *bytes, (size_t)block->size) != block->crc) {
        return stp_store_fail_block(store, block, "checksum");
    }
    return STP_OK;
}

stp_result stp_store_fail_index(const stp_store* store, const char* what, uint32_t index)
{
    return stp_fail(store->context, STP_ERROR_ARGUMENT, "%s: %s %u does not exist", store->path,
                    what, index);
}

bool stp_store_read_mapped(void* user, uint64_t offset, void* bytes, size_t size)
{
    const stp_store* store = user;
    bool whole = offset <= store->file.size && size <= store->file.size - offset;
    if (whole) {
        memcpy(bytes, store->file.bytes + offset, size);
    }
    return whole;
}

bool stp_store_is_clustered(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_MESHES]);
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    return stp_store_block_at(store, records[index].block)->kind == STP_BLOCK_CLUSTERS;
}

const stp_store_mesh* stp_store_describe_mesh(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_MESHES]);
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    return &records[index].mesh;
}

const stp_store_point_set* stp_store_describe_point_set(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_POINT_SETS]);
    const stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    return &records[index].points;
}

const stp_splats* stp_store_describe_splat_set(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_SPLAT_SETS]);
    const stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    return &records[index].splats;
}
