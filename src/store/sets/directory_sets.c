// SPDX-License-Identifier: MIT
// Links the tables of a directory: sets to their octaves and breakpoints, owners to their blocks.
#include "store/bytes/chunks.h"
#include "store/bytes/operators.h"
#include "store/file/block_table.h"
#include "store/file/texture_images.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

static stp_result fail_format(const stp_store* store, const char* what, uint32_t index,
                              const char* fault)
{
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: %s %u: %s", store->path, what, index,
                    fault);
}

// Blocks follow each other without gaps up to the end of the file, coarse splats first.
static stp_result check_blocks(const stp_store* store)
{
    uint64_t end = store->data_offset;
    const stp_store_block* before = NULL;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_BLOCKS]; ++i) {
        const stp_store_block* block = stp_store_block_at(store, i);
        if (block->offset != stp_store_align(end, STP_STORE_ALIGNMENT) ||
            block->offset > store->file_bytes || block->size > store->file_bytes - block->offset) {
            return fail_format(store, "block", i, "does not start right after the previous block");
        }
        if (!(block->radius >= 0.0f) || (before != NULL && block->radius > before->radius)) {
            return fail_format(store, "block", i, "has a larger radius than the block before it");
        }
        end = block->offset + block->size;
        before = block;
    }
    if (end != store->file_bytes) {
        return stp_fail(store->context, STP_ERROR_FORMAT, "%s: has bytes after the last block",
                        store->path);
    }
    return STP_OK;
}

// Whether this version can decode a block of a mesh, a point set, splats or leaves.
static bool knows_encoding(const stp_store* store, const stp_store_block* block)
{
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    bool splats = block->kind == STP_BLOCK_SPLATS;
    uint32_t columns = splats ? sets[block->owner].splats.columns : 0;
    switch (block->encoding) {
    case STP_STORE_ENCODING_PLAIN:
        return true;
    case STP_STORE_ENCODING_CHUNKS:
        return splats;
    case STP_STORE_ENCODING_OPERATORS:
        return splats && columns == STP_OPERATOR_COLUMNS;
    case STP_STORE_ENCODING_LIT:
        return splats && columns == 0;
    default:
        return false;
    }
}

// The block that an owner requires. For an octave, `wanted.size` is ignored.
static stp_result check_block(const stp_store* store, uint32_t index, stp_store_block wanted)
{
    static const char* const names[STP_BLOCK_END] = {
        [STP_BLOCK_MESH] = "mesh",       [STP_BLOCK_POINT_SET] = "point set",
        [STP_BLOCK_TEXTURE] = "texture", [STP_BLOCK_SPLATS] = "splat set",
        [STP_BLOCK_CLUSTERS] = "mesh",   [STP_BLOCK_LEAVES] = "splat set",
    };
    assert(wanted.kind < STP_BLOCK_END && names[wanted.kind] != NULL);
    if (index >= store->counts[STP_SECTION_BLOCKS]) {
        return fail_format(store, names[wanted.kind], wanted.owner, "its block does not exist");
    }
    const stp_store_block* block = stp_store_block_at(store, index);
    if (block->kind != wanted.kind || block->owner != wanted.owner ||
        block->octave != wanted.octave) {
        return fail_format(store, names[wanted.kind], wanted.owner,
                           "its block belongs to another owner");
    }
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    if (!knows_encoding(store, block)) {
        return stp_fail(store->context, STP_ERROR_UNSUPPORTED,
                        "%s: %s %u: its block has the unknown encoding %u", store->path,
                        names[wanted.kind], wanted.owner, block->encoding);
    }
    bool fits = block->size == wanted.size;
    if (wanted.kind == STP_BLOCK_SPLATS) {
        stp_store_octave_span span =
            stp_store_span_of(&sets[wanted.owner].splats, wanted.octave, block->encoding);
        fits = stp_store_can_hold(&span, block->size);
    }
    if (!fits) {
        return fail_format(store, names[wanted.kind], wanted.owner,
                           "its block has the wrong size for its counts");
    }
    return STP_OK;
}

// Finds a set's breakpoints and octaves, which are stored in the order of the sets.
static stp_result gather_set(stp_store* store, uint32_t index, uint64_t* octave_end,
                             uint64_t* breakpoint_end)
{
    stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
    const stp_store_breakpoint* breakpoints = store->tables[STP_SECTION_BREAKPOINTS];
    stp_store_set_record* set = &sets[index];
    stp_splats* splats = &set->splats;
    if (splats->octave_count > STP_OCTAVE_LIMIT || splats->table.size > STP_PREFIX_TABLE_SIZE) {
        return fail_format(store, "splat set", index, "has too many octaves or breakpoints");
    }
    if (set->first_octave != *octave_end || set->first_breakpoint != *breakpoint_end) {
        return fail_format(store, "splat set", index,
                           "its octaves or breakpoints do not follow those of the previous set");
    }
    *octave_end += splats->octave_count;
    *breakpoint_end += splats->table.size;
    if (*octave_end > store->counts[STP_SECTION_OCTAVES] ||
        *breakpoint_end > store->counts[STP_SECTION_BREAKPOINTS]) {
        return fail_format(store, "splat set", index, "its octaves or breakpoints are missing");
    }
    splats->plain_coverages = store->minor < STP_STORE_MINOR_COVERAGES;
    for (uint32_t i = 0; i < splats->octave_count; ++i) {
        splats->octave_ends[i] = octaves[set->first_octave + i].end;
    }
    for (uint32_t i = 0; i < splats->table.size; ++i) {
        splats->table.count[i] = breakpoints[set->first_breakpoint + i].count;
        splats->table.radius[i] = breakpoints[set->first_breakpoint + i].radius;
    }
    return STP_OK;
}

// Links each octave to its block, in order. Counts the octaves that a partial file holds whole.
static stp_result link_octaves(stp_store* store, uint32_t index)
{
    stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
    const stp_splats* splats = &sets[index].splats;
    sets[index].whole = 0;
    for (uint32_t k = 0; k < splats->octave_count; ++k) {
        uint32_t number = octaves[sets[index].first_octave + k].block;
        stp_store_block wanted = {.kind = STP_BLOCK_SPLATS, .owner = index, .octave = k};
        stp_result result = check_block(store, number, wanted);
        if (result != STP_OK) {
            return result;
        }
        if (k > 0 && number <= octaves[sets[index].first_octave + k - 1].block) {
            return fail_format(store, "splat set", index, "its octaves are out of order");
        }
        if (stp_store_block_at(store, number)->encoding == STP_STORE_ENCODING_LIT) {
            sets[index].splats.light_octaves |= 1u << k;
        }
        bool here = stp_store_is_block_here(store, stp_store_block_at(store, number));
        assert((!here || sets[index].whole == k) && "blocks in order: complete octaves come first");
        sets[index].whole += here;
    }
    return STP_OK;
}

static stp_result link_sets(stp_store* store)
{
    const stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    stp_store_validator validator = stp_store_own_validator(store);
    uint64_t octave_end = 0, breakpoint_end = 0;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_SPLAT_SETS]; ++i) {
        stp_result result = gather_set(store, i, &octave_end, &breakpoint_end);
        if (result == STP_OK) {
            result = stp_store_validate_splat_set(&validator, i, &sets[i].splats);
        }
        if (result == STP_OK) {
            result = link_octaves(store, i);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    if (octave_end != store->counts[STP_SECTION_OCTAVES] ||
        breakpoint_end != store->counts[STP_SECTION_BREAKPOINTS]) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: octaves or breakpoints belong to no splat set", store->path);
    }
    return STP_OK;
}

static bool is_coded(const stp_store* store, uint32_t mesh)
{
    const stp_store_clusters_record* records = store->tables[STP_SECTION_CLUSTERS];
    assert(records == NULL || mesh < store->counts[STP_SECTION_CLUSTERS]);
    return records != NULL && records[mesh].cluster_count != STP_STORE_NONE;
}

static stp_result link_mesh(const stp_store* store, uint32_t index)
{
    const stp_store_mesh_record* meshes = store->tables[STP_SECTION_MESHES];
    const stp_store_mesh_record* record = &meshes[index];
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_block wanted = {
        .kind = STP_BLOCK_MESH,
        .owner = index,
        .size = stp_store_mesh_columns(record->mesh.vertex_count, record->mesh.triangle_count,
                                       record->present, columns),
    };
    if (record->present > (STP_COLUMN_NORMALS | STP_COLUMN_COLORS | STP_COLUMN_TEXCOORDS_0 |
                           STP_COLUMN_TEXCOORDS_1)) {
        return fail_format(store, "mesh", index, "has columns that this version does not define");
    }
    if (is_coded(store, index)) { // the coded block gives the size
        wanted.kind = STP_BLOCK_CLUSTERS;
        wanted.size = record->block < store->counts[STP_SECTION_BLOCKS]
                          ? stp_store_block_at(store, record->block)->size
                          : 0;
    }
    return check_block(store, record->block, wanted);
}

// Points held by a set of splats have no block.
static stp_result link_held_points(const stp_store* store, uint32_t index)
{
    const stp_store_point_record* sets = store->tables[STP_SECTION_POINT_SETS];
    const stp_store_set_record* splats = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_point_record* record = &sets[index];
    assert(record->points.held_by != 0);
    uint32_t set = record->points.held_by - 1;
    if (record->block != STP_STORE_NONE ||
        record->present != (STP_COLUMN_NORMALS | STP_COLUMN_COLORS) ||
        set >= store->counts[STP_SECTION_SPLAT_SETS]) {
        return fail_format(store, "point set", index, "names no splat set that can hold it");
    }
    stp_store_validator validator = stp_store_own_validator(store);
    return stp_store_validate_held_points(&validator, index, &record->points, &splats[set].splats);
}

static stp_result link_points(const stp_store* store, uint32_t index)
{
    const stp_store_point_record* sets = store->tables[STP_SECTION_POINT_SETS];
    const stp_store_point_record* record = &sets[index];
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_block wanted = {
        .kind = STP_BLOCK_POINT_SET,
        .owner = index,
        .size = stp_store_point_columns(record->points.point_count, record->present, columns),
    };
    if (record->present > (STP_COLUMN_NORMALS | STP_COLUMN_COLORS)) {
        return fail_format(store, "point set", index,
                           "has columns that this version does not define");
    }
    if (record->points.held_by != 0) {
        return link_held_points(store, index);
    }
    return check_block(store, record->block, wanted);
}

// Links each set to its leaves.
// @param owned number of sets with leaves
static stp_result link_leaves(const stp_store* store, uint64_t* owned)
{
    const stp_store_leaves_record* records = store->tables[STP_SECTION_LEAVES];
    uint32_t count = store->counts[STP_SECTION_LEAVES],
             sets = store->counts[STP_SECTION_SPLAT_SETS];
    stp_result result = STP_OK;
    *owned = 0;
    if (store->known[STP_SECTION_LEAVES] != NULL && count != sets) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: lists leaves for %u splat sets but has %u", store->path, count, sets);
    }
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        if (records[i].leaf_count == 0 && records[i].block != STP_STORE_NONE) {
            return fail_format(store, "splat set", i, "has a block of leaves but no leaves");
        }
        stp_store_block wanted = {.kind = STP_BLOCK_LEAVES,
                                  .owner = i,
                                  .size = STP_STORE_LEAF_BYTES * (uint64_t)records[i].leaf_count};
        if (records[i].leaf_count > 0) {
            *owned += 1;
            result = check_block(store, records[i].block, wanted);
        }
    }
    return result;
}

stp_result stp_store_link_blocks(stp_store* store)
{
    stp_result result = check_blocks(store);
    if (result == STP_OK && store->known[STP_SECTION_CLUSTERS] != NULL &&
        store->counts[STP_SECTION_CLUSTERS] != store->counts[STP_SECTION_MESHES]) {
        result = stp_fail(store->context, STP_ERROR_FORMAT,
                          "%s: lists clusters for %u meshes but has %u", store->path,
                          store->counts[STP_SECTION_CLUSTERS], store->counts[STP_SECTION_MESHES]);
    }
    if (result == STP_OK) {
        result = link_sets(store);
    }
    for (uint32_t i = 0; i < store->counts[STP_SECTION_MESHES] && result == STP_OK; ++i) {
        result = link_mesh(store, i);
    }
    for (uint32_t i = 0; i < store->counts[STP_SECTION_POINT_SETS] && result == STP_OK; ++i) {
        result = link_points(store, i);
    }
    result = result == STP_OK ? stp_store_link_textures(store) : result;
    uint64_t leaf_tables = 0;
    result = result == STP_OK ? link_leaves(store, &leaf_tables) : result;
    result = result == STP_OK ? stp_store_link_certainty(store) : result;
    if (result != STP_OK) {
        return result;
    }
    // every owner has its own block (shared textures: the first one), so equal counts mean that
    // every block has an owner
    const stp_store_point_record* points = store->tables[STP_SECTION_POINT_SETS];
    uint64_t owned = (uint64_t)store->counts[STP_SECTION_OCTAVES] +
                     store->counts[STP_SECTION_MESHES] + stp_store_count_texture_blocks(store) +
                     leaf_tables;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_POINT_SETS]; ++i) {
        owned += points[i].points.held_by == 0 ? 1 : 0;
    }
    uint64_t known = 0;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_BLOCKS]; ++i) {
        uint32_t kind = stp_store_block_at(store, i)->kind;
        known += stp_store_knows_block(kind) ? 1 : 0;
    }
    if (known != owned) {
        return stp_fail(store->context, STP_ERROR_FORMAT, "%s: a block has no owner", store->path);
    }
    return stp_store_link_attributes(store);
}
