// SPDX-License-Identifier: MIT
// Bulk data: checked when first asked for, then straight from the file, or joined from its octaves.
#include "store/internal.h"

#include <string.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "columns are used straight from the file, which is little-endian"
#endif

stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                  const unsigned char** bytes)
{
    if (block->offset + block->size > store->file.size) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends before the block at %llu does", store->path,
                        (unsigned long long)block->offset);
    }
    *bytes = store->file.bytes + block->offset;
    if (stp_store_crc(0, *bytes, (size_t)block->size) != block->crc) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: the checksum of the block at %llu is wrong", store->path,
                        (unsigned long long)block->offset);
    }
    return STP_OK;
}

static stp_result fail_index(const stp_store* store, const char* what, uint32_t index)
{
    return stp_fail(store->context, STP_ERROR_ARGUMENT, "%s: %s %u does not exist", store->path,
                    what, index);
}

// The first byte of a column; NULL where the file does not have it.
static const void* column_at(const unsigned char* bytes, const stp_store_column* column,
                             bool present)
{
    return present ? bytes + column->offset : NULL;
}

stp_result stp_store_get_mesh(stp_store* store, uint32_t index, stp_store_mesh* mesh)
{
    if (index >= store->directory.mesh_count) {
        return fail_index(store, "mesh", index);
    }
    stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    stp_store_mesh_record* record = &records[index];
    if (!record->checked) {
        const unsigned char* bytes = NULL;
        stp_result result =
            stp_store_verify_block(store, stp_store_block_at(store, record->block), &bytes);
        if (result != STP_OK) {
            return result;
        }
        stp_store_column c[STP_STORE_COLUMN_LIMIT];
        stp_store_mesh made = record->mesh;
        uint32_t has = record->present;
        stp_store_mesh_columns(made.vertex_count, made.triangle_count, has, c);
        made.positions = column_at(bytes, &c[STP_MESH_POSITIONS], true);
        made.normals = column_at(bytes, &c[STP_MESH_NORMALS], (has & STP_COLUMN_NORMALS) != 0);
        made.texcoords[0] =
            column_at(bytes, &c[STP_MESH_TEXCOORDS_0], (has & STP_COLUMN_TEXCOORDS_0) != 0);
        made.texcoords[1] =
            column_at(bytes, &c[STP_MESH_TEXCOORDS_1], (has & STP_COLUMN_TEXCOORDS_1) != 0);
        made.colors = column_at(bytes, &c[STP_MESH_COLORS], (has & STP_COLUMN_COLORS) != 0);
        made.indices = column_at(bytes, &c[STP_MESH_INDICES], true);
        stp_store_judge judge = stp_store_own_judge(store);
        result = stp_store_judge_mesh_data(&judge, index, &made);
        if (result != STP_OK) {
            return result;
        }
        record->mesh = made;
        record->checked = true;
    }
    *mesh = record->mesh;
    return STP_OK;
}

stp_result stp_store_get_point_set(stp_store* store, uint32_t index, stp_store_point_set* points)
{
    if (index >= store->directory.point_set_count) {
        return fail_index(store, "point set", index);
    }
    stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    stp_store_point_record* record = &records[index];
    if (!record->checked) {
        const unsigned char* bytes = NULL;
        stp_result result =
            stp_store_verify_block(store, stp_store_block_at(store, record->block), &bytes);
        if (result != STP_OK) {
            return result;
        }
        stp_store_column c[STP_STORE_COLUMN_LIMIT];
        stp_store_point_set made = record->points;
        uint32_t has = record->present;
        stp_store_point_columns(made.point_count, has, c);
        made.positions = column_at(bytes, &c[STP_POINT_POSITIONS], true);
        made.normals = column_at(bytes, &c[STP_POINT_NORMALS], (has & STP_COLUMN_NORMALS) != 0);
        made.colors = column_at(bytes, &c[STP_POINT_COLORS], (has & STP_COLUMN_COLORS) != 0);
        stp_store_judge judge = stp_store_own_judge(store);
        result = stp_store_judge_point_data(&judge, index, &made);
        if (result != STP_OK) {
            return result;
        }
        record->points = made;
        record->checked = true;
    }
    *points = record->points;
    return STP_OK;
}

stp_result stp_store_get_texture(stp_store* store, uint32_t index, stp_store_texture* texture)
{
    if (index >= store->directory.texture_count) {
        return fail_index(store, "texture", index);
    }
    stp_store_texture_record* records = store->tables[STP_SECTION_TEXTURES];
    stp_store_texture_record* record = &records[index];
    if (!record->checked) {
        const unsigned char* bytes = NULL;
        stp_result result =
            stp_store_verify_block(store, stp_store_block_at(store, record->block), &bytes);
        if (result != STP_OK) {
            return result;
        }
        record->texture.texels = bytes;
        record->checked = true;
    }
    *texture = record->texture;
    return STP_OK;
}

void stp_store_cut_surfels(stp_surfels* surfels, uint32_t octave_count)
{
    if (octave_count >= surfels->octave_count) {
        return;
    }
    surfels->octave_count = octave_count;
    surfels->count = octave_count == 0 ? 0 : surfels->octave_ends[octave_count - 1];
    stp_prefix_table* table = &surfels->table;
    while (table->size > 0 && table->count[table->size - 1] > surfels->count) {
        table->size -= 1;
    }
    if (surfels->paper_count > surfels->count) { // the estimate needs its prefix
        surfels->paper_count = 0;
        surfels->paper_radius = 0.0f;
    }
}

// Room for all columns of a set, each 64-byte aligned; no more than a little above its blocks in
// the file.
static stp_result reserve_columns(const stp_store* store, stp_store_surfels_record* record)
{
    stp_surfels* surfels = &record->surfels;
    uint64_t n = surfels->count;
    uint64_t entries = stp_store_pyramid_begin(surfels, surfels->octave_count);
    uint64_t sizes[STP_SURFEL_COLUMNS] = {6 * n, 2 * n, n, 3 * entries, entries};
    uint64_t offsets[STP_SURFEL_COLUMNS], end = 0;
    for (int i = 0; i < STP_SURFEL_COLUMNS; ++i) {
        offsets[i] = end;
        end = stp_store_align(end + sizes[i], STP_STORE_ALIGNMENT);
    }
    unsigned char* memory = stp_alloc(store->context, (size_t)end);
    if (memory == NULL) {
        return stp_fail_memory(store->context);
    }
    record->memory = memory;
    surfels->positions = (uint16_t*)(void*)(memory + offsets[STP_SURFEL_POSITIONS]);
    surfels->normals = (int8_t*)(memory + offsets[STP_SURFEL_NORMALS]);
    surfels->materials = memory + offsets[STP_SURFEL_MATERIALS];
    surfels->colors = memory + offsets[STP_SURFEL_COLORS];
    surfels->coverages = memory + offsets[STP_SURFEL_COVERAGES];
    return STP_OK;
}

// Checks an octave's block and copies its columns to their places.
static stp_result add_octave(const stp_store* store, uint32_t index, uint32_t octave)
{
    stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
    stp_surfels* surfels = &records[index].surfels;
    uint32_t number = octaves[records[index].first_octave + octave].block;
    const unsigned char* bytes = NULL;
    stp_result result = stp_store_verify_block(store, stp_store_block_at(store, number), &bytes);
    if (result != STP_OK || bytes == NULL) {
        return result;
    }
    stp_store_column c[STP_STORE_COLUMN_LIMIT];
    stp_store_surfel_columns(surfels, octave, c);
    stp_store_judge judge = stp_store_own_judge(store);
    result =
        stp_store_judge_surfel_data(&judge, index, bytes + c[STP_SURFEL_MATERIALS].offset,
                                    c[STP_SURFEL_MATERIALS].size, store->directory.shading_count);
    if (result != STP_OK) {
        return result;
    }
    size_t first = stp_store_octave_begin(surfels, octave);
    size_t entry = (size_t)stp_store_pyramid_begin(surfels, octave);
    void* targets[STP_SURFEL_COLUMNS] = {
        [STP_SURFEL_POSITIONS] = surfels->positions + 3 * first,
        [STP_SURFEL_NORMALS] = surfels->normals + 2 * first,
        [STP_SURFEL_MATERIALS] = surfels->materials + first,
        [STP_SURFEL_COLORS] = surfels->colors + 3 * entry,
        [STP_SURFEL_COVERAGES] = surfels->coverages + entry,
    };
    for (int i = 0; i < STP_SURFEL_COLUMNS; ++i) {
        memcpy(targets[i], bytes + c[i].offset, (size_t)c[i].size);
    }
    return STP_OK;
}

stp_result stp_store_get_surfels_prefix(stp_store* store, uint32_t index, uint32_t octave_count,
                                        stp_surfels* surfels)
{
    if (index >= store->directory.surfels_count) {
        return fail_index(store, "surfel set", index);
    }
    stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    stp_store_surfels_record* record = &records[index];
    if (octave_count > record->surfels.octave_count) {
        octave_count = record->surfels.octave_count;
    }
    if (octave_count > record->ready && record->memory == NULL) {
        stp_result result = reserve_columns(store, record);
        if (result != STP_OK) {
            return result;
        }
    }
    while (record->ready < octave_count) {
        stp_result result = add_octave(store, index, record->ready);
        if (result != STP_OK) {
            return result;
        }
        record->ready += 1;
    }
    *surfels = record->surfels;
    stp_store_cut_surfels(surfels, octave_count);
    return STP_OK;
}

stp_result stp_store_get_surfels(stp_store* store, uint32_t index, stp_surfels* surfels)
{
    return stp_store_get_surfels_prefix(store, index, STP_OCTAVE_LIMIT, surfels);
}

const stp_store_mesh* stp_store_describe_mesh(const stp_store* store, uint32_t index)
{
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    return &records[index].mesh;
}

const stp_store_point_set* stp_store_describe_point_set(const stp_store* store, uint32_t index)
{
    const stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    return &records[index].points;
}

const stp_store_texture* stp_store_describe_texture(const stp_store* store, uint32_t index)
{
    const stp_store_texture_record* records = store->tables[STP_SECTION_TEXTURES];
    return &records[index].texture;
}

const stp_surfels* stp_store_describe_surfels(const stp_store* store, uint32_t index)
{
    const stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    return &records[index].surfels;
}
