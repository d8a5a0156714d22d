// SPDX-License-Identifier: MIT
// Checks a whole file: every checksum, every padding byte, every invariant.
#include "base/splats/progressive.h"
#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/file/content_sizes.h"
#include "store/file/tables.h"
#include "store/reader/scene_summary.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

#define SMALL_DIRECTORY ((uint64_t)512 << 10) // a quick check reads smaller ones whole

// Reads and decodes all columns of an octave, but keeps only those that are validated.
static stp_result check_splats(stp_store* store, const stp_store_block* block)
{
    stp_store_octave_span span = stp_store_span_of(
        stp_store_describe_splat_set(store, block->owner), block->octave, block->encoding);
    assert(block->encoding != STP_STORE_ENCODING_OPERATORS && "check_operators decodes these");
    stp_store_block_source source = {.block = block, .read = stp_store_read_mapped, .user = store};
    uint32_t count = span.end - span.first;
    uint64_t read_bytes = 0;
    size_t room = ((size_t)count + 3) & ~(size_t)3;
    unsigned char* materials = stp_alloc_array(store->context, room, 9);
    if (materials == NULL) {
        return stp_fail_memory(store->context);
    }
    uint32_t* options = (uint32_t*)(void*)(materials + room);
    stp_store_splat_data data = {
        .count = count,
        .materials = materials,
        .shapes = (span.columns & STP_SPLATS_SHAPES) != 0 ? options : NULL,
        .ranges = (span.columns & STP_SPLATS_RANGES) != 0 ? options + count : NULL,
    };
    void* targets[STP_OCTAVE_COLUMNS] = {
        [STP_OCTAVE_MATERIALS] = materials,
        [STP_OCTAVE_SHAPES] = options,
        [STP_OCTAVE_RANGES] = options + count,
    };
    const char* fault = stp_store_read_chunks(&source, &span, 0, stp_store_chunk_count(&span),
                                              targets, &read_bytes);
    stp_store_validator validator = stp_store_own_validator(store);
    stp_result result = fault != NULL
                            ? stp_store_fail_block(store, block, fault)
                            : stp_store_validate_splat_data(&validator, block->owner, &data,
                                                            store->directory.shading_count);
    stp_free(store->context, materials);
    return result;
}

// Operators are decoded for the whole set at its first octave: each octave needs the ones before.
static stp_result check_operators(stp_store* store, uint32_t index)
{
    stp_splats set = *stp_store_describe_splat_set(store, index);
    stp_store_joined* joined = stp_store_reserve_columns(store->context, &set);
    stp_result result = joined != NULL ? STP_OK : stp_fail_memory(store->context);
    for (uint32_t k = 0; k < set.octave_count && result == STP_OK; ++k) {
        result = stp_store_add_octave(store, index, k, &set);
    }
    if (result == STP_OK) {
        stp_progressive_counts counts = stp_progressive_count(set.ranges, set.count);
        if (counts.parents != counts.splits || set.count != counts.base + 2 * counts.splits) {
            result = stp_fail(store->context, STP_ERROR_FORMAT,
                              "%s: splat set %u: has %u parents and %u splits", store->path, index,
                              counts.parents, counts.splits);
        }
    }
    stp_free(store->context, joined);
    return result;
}

static stp_result check_zeros(const stp_store* store, uint64_t begin, uint64_t end)
{
    assert(begin <= end && "blocks and columns do not overlap");
    for (uint64_t at = begin; at < end; ++at) {
        if (store->file.bytes[at] != 0) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: the byte at %llu, between blocks or columns, is not zero",
                            store->path, (unsigned long long)at);
        }
    }
    return STP_OK;
}

// The bytes between the columns of a mesh or point set.
static stp_result check_gaps(const stp_store* store, const stp_store_block* block,
                             const stp_store_column columns[STP_STORE_COLUMN_LIMIT])
{
    stp_result result = STP_OK;
    uint64_t end = 0;
    for (int i = 0; i < STP_STORE_COLUMN_LIMIT && result == STP_OK; ++i) {
        result = check_zeros(store, block->offset + end, block->offset + columns[i].offset);
        end = columns[i].offset + columns[i].size;
    }
    return result;
}

static stp_result check_mesh(stp_store* store, const stp_store_block* block)
{
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    stp_store_mesh mesh;
    stp_result result = stp_store_get_mesh(store, block->owner, &mesh);
    if (result != STP_OK) {
        return result;
    }
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_mesh_columns(mesh.vertex_count, mesh.triangle_count, records[block->owner].present,
                           columns);
    return check_gaps(store, block, columns);
}

static stp_result check_points(stp_store* store, const stp_store_block* block)
{
    const stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    stp_store_point_set points;
    stp_result result = stp_store_get_point_set(store, block->owner, &points);
    if (result != STP_OK) {
        return result;
    }
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_point_columns(points.point_count, records[block->owner].present, columns);
    return check_gaps(store, block, columns);
}

// Any texel value is valid; picture files must decode.
static stp_result check_texture(stp_store* store, const stp_store_block* block)
{
    stp_store_texture texture;
    uint8_t* owned;
    stp_result result = stp_store_load_texture(store, block->owner, &texture, &owned);
    stp_free(store->context, owned);
    return result;
}

static stp_result check_block(stp_store* store, const stp_store_block* block)
{
    const unsigned char* bytes = NULL;
    switch (block->kind) {
    case STP_BLOCK_MESH:
        return check_mesh(store, block);
    case STP_BLOCK_CLUSTERS: {
        stp_clusters clusters;
        return stp_store_get_clusters(store, block->owner, &clusters);
    }
    case STP_BLOCK_POINT_SET:
        return check_points(store, block);
    case STP_BLOCK_SPLATS:
        if (stp_store_has_operators(store, block->owner, STP_OCTAVE_LIMIT)) {
            return block->octave == 0 ? check_operators(store, block->owner) : STP_OK;
        }
        return check_splats(store, block);
    case STP_BLOCK_LEAVES: {
        stp_store_leaves leaves;
        return stp_store_get_leaves(store, block->owner, &leaves);
    }
    case STP_BLOCK_TEXTURE:
        return check_texture(store, block);
    case STP_BLOCK_ATTRIBUTES:
    case STP_BLOCK_POINT_ATTRIBUTES:
        return stp_store_check_values(store, block);
    default: // block kinds of newer versions
        return stp_store_verify_block(store, block, &bytes);
    }
}

static stp_result check_blocks(stp_store* store, stp_store_check_report* report)
{
    uint64_t end = store->data_offset;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_BLOCKS]; ++i) {
        const stp_store_block* block = stp_store_block_at(store, i);
        stp_result result = check_zeros(store, end, block->offset);
        if (result == STP_OK) {
            result = check_block(store, block);
        }
        if (result != STP_OK) {
            return result;
        }
        end = block->offset + block->size;
        report->bytes_checked = end;
    }
    assert(end == store->file_bytes && "the last block ends the file");
    return STP_OK;
}

// Opening the file has checked the header, section table and summary.
static stp_result check_partial(stp_store* store, stp_store_check_report* report)
{
    stp_result result = stp_store_check_head(store);
    report->bytes_checked = store->section_end + store->bytes_checked;
    return result;
}

stp_result stp_store_check_open(stp_store* store, bool quick, stp_store_check_report* report)
{
    const stp_store_section* blocks = store->known[STP_SECTION_BLOCKS];
    *report = (stp_store_check_report){
        .file_bytes = store->file.size,
        .blocks = blocks != NULL ? blocks->count : 0,
    };
    if (store->only_summary) {
        return check_partial(store, report);
    }
    stp_result result = stp_store_load_objects(store);
    for (uint32_t i = 0; i < store->section_count && result == STP_OK; ++i) {
        const stp_store_section* section = &store->sections[i];
        result = stp_store_verify_section(store, section);
        if (result == STP_OK) {
            uint64_t size =
                stp_store_is_packed(section) ? stp_store_content_bytes(section) : section->size;
            result = stp_store_verify_range(store, section, 0, size);
        }
    }
    result = result == STP_OK ? stp_store_check_summary(store) : result;
    report->bytes_checked = store->data_offset;
    if (result == STP_OK && !quick) {
        result = check_blocks(store, report);
    }
    return result;
}

stp_result stp_store_check_with_report(stp_context* context, const char* path, bool quick,
                                       stp_store_check_report* report)
{
    *report = (stp_store_check_report){0};
    stp_store* store = NULL;
    stp_store_open_desc desc = {.summary_only = quick};
    stp_result result = stp_store_open_with(context, path, &desc, &store);
    if (result == STP_OK && store->only_summary && store->data_offset <= SMALL_DIRECTORY) {
        stp_store_close(store);
        result = stp_store_open(context, path, &store);
    }
    if (result == STP_OK) {
        result = stp_store_check_open(store, quick, report);
        stp_store_close(store);
    }
    return result;
}

stp_result stp_store_check(stp_context* context, const char* path, bool quick)
{
    stp_store_check_report report;
    return stp_store_check_with_report(context, path, quick, &report);
}
