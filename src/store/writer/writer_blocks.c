// SPDX-License-Identifier: MIT
// Writes blocks: columns of meshes and point sets, clusters, texels (octaves: writer_chunks.c).
// Then the directory entries that depend on them.
#include "store/bytes/columns.h"
#include "store/bytes/packed.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <string.h>

#define RELEASE_BYTES ((uint64_t)32 << 20)
// What reading a short octave makes resident: it has about 4 columns.
#define OCTAVE_PAGES ((uint64_t)4 * STP_FAULT_AROUND)

typedef struct source_column {
    const void* bytes; ///< start of the column in the content
} source_column;

// Writes a block's columns with zero padding between them.
static stp_result write_columns(stp_store_writing* w, const source_column* sources,
                                const stp_store_column columns[STP_STORE_COLUMN_LIMIT],
                                size_t count)
{
    static const unsigned char zeros[STP_STORE_COLUMN_ALIGNMENT] = {0};
    uint64_t end = 0;
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        assert(columns[i].offset >= end && columns[i].offset - end < STP_STORE_COLUMN_ALIGNMENT);
        result = stp_store_emit(w, zeros, (size_t)(columns[i].offset - end));
        if (result == STP_OK && columns[i].size != 0) {
            result = stp_store_emit(w, sources[i].bytes, (size_t)columns[i].size);
        }
        end = columns[i].offset + columns[i].size;
    }
    return result;
}

static stp_result write_mesh(stp_store_writing* w, uint32_t index)
{
    const stp_store_mesh* mesh = &w->content->meshes[index];
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_mesh_columns(mesh->vertex_count, mesh->triangle_count, stp_store_mesh_present(mesh),
                           columns);
    source_column sources[STP_MESH_COLUMNS] = {
        [STP_MESH_POSITIONS] = {mesh->positions},
        [STP_MESH_NORMALS] = {mesh->normals},
        [STP_MESH_TEXCOORDS_0] = {mesh->texcoords[0]},
        [STP_MESH_TEXCOORDS_1] = {mesh->texcoords[1]},
        [STP_MESH_COLORS] = {mesh->colors},
        [STP_MESH_INDICES] = {mesh->indices},
    };
    return write_columns(w, sources, columns, STP_MESH_COLUMNS);
}

static stp_result write_points(stp_store_writing* w, uint32_t index)
{
    const stp_store_point_set* points = &w->content->point_sets[index];
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_point_columns(points->point_count, stp_store_points_present(points), columns);
    source_column sources[STP_POINT_COLUMNS] = {
        [STP_POINT_POSITIONS] = {points->positions},
        [STP_POINT_NORMALS] = {points->normals},
        [STP_POINT_COLORS] = {points->colors},
    };
    return write_columns(w, sources, columns, STP_POINT_COLUMNS);
}

// Coded meshes may exceed memory, so each is checked just before it is written.
static stp_result write_clusters(stp_store_writing* w, uint32_t index)
{
    const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, index);
    stp_clusters clusters;
    const char* fault = stp_clusters_open(coded->bytes, coded->size, &clusters);
    if (fault == NULL && (clusters.cluster_count != coded->cluster_count ||
                          clusters.triangle_count != coded->triangle_count ||
                          clusters.vertex_count != coded->vertex_count)) {
        fault = "has clusters whose counts differ from its own";
    }
    if (fault != NULL) {
        return stp_fail(w->context, STP_ERROR_ARGUMENT, "%s: mesh %u %s", w->path, index, fault);
    }
    return stp_store_emit(w, coded->bytes, coded->size);
}

static stp_result write_block(stp_store_writing* w, const stp_store_block* block)
{
    switch (block->kind) {
    case STP_BLOCK_MESH:
        return write_mesh(w, block->owner);
    case STP_BLOCK_CLUSTERS:
        return write_clusters(w, block->owner);
    case STP_BLOCK_POINT_SET:
        return write_points(w, block->owner);
    case STP_BLOCK_LEAVES:
        assert(block->size ==
               STP_STORE_LEAF_BYTES * (uint64_t)w->content->sets[block->owner].leaf_count);
        return stp_store_emit(w, w->content->sets[block->owner].leaves, (size_t)block->size);
    default: {
        assert(block->kind == STP_BLOCK_TEXTURE);
        const stp_store_texture* texture = &w->content->textures[block->owner];
        return stp_store_emit(w, texture->encoded != NULL ? texture->encoded : texture->texels,
                              (size_t)block->size);
    }
    }
}

static stp_result write_plain(stp_store_writing* w, stp_store_block* block)
{
    stp_result result = stp_store_pad(w);
    block->offset = stp_file_writer_size(w->file);
    w->crc = 0;
    if (result == STP_OK) {
        result = write_block(w, block);
    }
    block->crc = w->crc;
    assert(result != STP_OK || stp_file_writer_size(w->file) == block->offset + block->size);
    return result;
}

void stp_store_count_read(stp_store_writing* w, uint64_t bytes)
{
    w->unreleased_bytes += bytes;
    if (w->content->release_pages != NULL && w->unreleased_bytes >= RELEASE_BYTES) {
        w->unreleased_bytes = 0;
        w->content->release_pages(w->content->release_user);
    }
}

stp_result stp_store_write_blocks(stp_store_writing* w)
{
    stp_store_batch* batch = NULL;
    stp_result result = stp_store_batch_create(w, &batch);
    uint64_t written = stp_file_writer_size(w->file);
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        if (w->plan.blocks[i].kind == STP_BLOCK_SPLATS) {
            result = stp_store_batch_add(batch, i);
        } else { // after the octaves before it
            result = stp_store_batch_flush(batch);
            bool values = w->plan.blocks[i].kind == STP_BLOCK_ATTRIBUTES ||
                          w->plan.blocks[i].kind == STP_BLOCK_POINT_ATTRIBUTES;
            if (result == STP_OK) {
                result = values ? stp_store_write_values(w, &w->plan.blocks[i])
                                : write_plain(w, &w->plan.blocks[i]);
            }
        }
        uint64_t pages = w->plan.blocks[i].kind == STP_BLOCK_SPLATS ? OCTAVE_PAGES : 0;
        stp_store_count_read(w, stp_file_writer_size(w->file) - written + pages);
        written = stp_file_writer_size(w->file);
    }
    result = result == STP_OK ? stp_store_batch_flush(batch) : result;
    assert(result != STP_OK || w->plan.block_count == 0 ||
           w->plan.blocks[w->plan.block_count - 1].offset +
                   w->plan.blocks[w->plan.block_count - 1].size ==
               stp_file_writer_size(w->file));
    stp_store_batch_destroy(batch);
    return result;
}

stp_result stp_store_patch_section(stp_store_writing* w, uint32_t type, const void* elements,
                                   uint32_t count)
{
    stp_store_section* section = &w->sections[type];
    size_t element_size = stp_store_table_of(type)->element_size;
    unsigned char* bytes = STP_NEW_ARRAY(w->context, unsigned char, (size_t)section->size + 1);
    if (bytes == NULL) {
        return stp_fail_memory(w->context);
    }
    assert(section->count == count && !stp_store_is_packed(section));
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element;
        memcpy(&element, (const char*)elements + i * element_size, element_size);
        result =
            stp_store_code_element(w, type, i, &element, bytes + (size_t)i * section->record_size);
    }
    section->crc = stp_store_crc(0, bytes, (size_t)section->size);
    stp_store_page_sums_replace(&w->sums, type, bytes, (size_t)section->size);
    if (result == STP_OK) {
        result = stp_file_writer_patch(w->file, section->offset, bytes, (size_t)section->size);
    }
    stp_free(w->context, bytes);
    return result;
}
