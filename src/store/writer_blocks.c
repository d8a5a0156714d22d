// SPDX-License-Identifier: MIT
// The blocks: columns of meshes, point sets and octaves, clusters, texels; and the table of them.
#include "store/internal.h"
#include "store/matter.h"
#include "store/writing.h"

#include <assert.h>

#define RELEASE_BYTES ((uint64_t)32 << 20)

typedef struct source_column {
    const void* bytes; ///< where the column's run begins in the content
} source_column;

// Writes a block's columns, zero bytes between them.
static stp_result write_columns(stp_store_writing* w, const source_column* sources,
                                const stp_store_column columns[STP_STORE_COLUMN_LIMIT],
                                size_t count)
{
    static const unsigned char zeros[STP_STORE_COLUMN_ALIGNMENT] = {0};
    uint64_t end = 0;
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
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

static stp_result write_octave(stp_store_writing* w, uint32_t index, uint32_t octave)
{
    const stp_surfels* surfels = &w->content->surfels[index];
    size_t first = stp_store_octave_begin(surfels, octave);
    size_t entry = (size_t)stp_store_pyramid_begin(surfels, octave);
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    stp_store_surfel_columns(surfels, octave, columns);
    source_column sources[STP_SURFEL_COLUMNS] = {
        [STP_SURFEL_POSITIONS] = {surfels->positions + 3 * first},
        [STP_SURFEL_NORMALS] = {surfels->normals + 2 * first},
        [STP_SURFEL_MATERIALS] = {surfels->materials + first},
        [STP_SURFEL_COLORS] = {surfels->colors + 3 * entry},
        [STP_SURFEL_COVERAGES] = {surfels->coverages + entry},
    };
    return write_columns(w, sources, columns, STP_SURFEL_COLUMNS);
}

// Coded meshes may be more than memory holds: each is checked when its turn comes to be written.
static stp_result write_clusters(stp_store_writing* w, uint32_t index)
{
    const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, index);
    stp_clusters clusters;
    const char* fault = stp_clusters_open(coded->bytes, coded->size, &clusters);
    if (fault == NULL && (clusters.cluster_count != coded->cluster_count ||
                          clusters.triangle_count != coded->triangle_count ||
                          clusters.vertex_count != coded->vertex_count)) {
        fault = "has clusters of other counts than it says";
    }
    if (fault != NULL) {
        return stp_fail(w->context, STP_ERROR_ARGUMENT, "%s: mesh %u %s", w->path, index, fault);
    }
    return stp_store_emit(w, coded->bytes, coded->size);
}

static stp_result write_block(stp_store_writing* w, const stp_store_block* block)
{
    switch (block->kind) {
    case STP_BLOCK_SURFELS:
        return write_octave(w, block->owner, block->octave);
    case STP_BLOCK_MESH:
        return write_mesh(w, block->owner);
    case STP_BLOCK_CLUSTERS:
        return write_clusters(w, block->owner);
    case STP_BLOCK_POINT_SET:
        return write_points(w, block->owner);
    default:
        return stp_store_emit(w, w->content->textures[block->owner].texels, (size_t)block->size);
    }
}

stp_result stp_store_write_blocks(stp_store_writing* w)
{
    stp_result result = STP_OK;
    uint64_t released = 0;
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        stp_store_block* block = &w->plan.blocks[i];
        result = stp_store_pad(w);
        assert(result != STP_OK || stp_file_writer_size(w->file) == block->offset);
        w->crc = 0;
        if (result == STP_OK) {
            result = write_block(w, block);
        }
        block->crc = w->crc;
        assert(result != STP_OK || stp_file_writer_size(w->file) == block->offset + block->size);
        if (w->content->release_pages != NULL && block->offset - released >= RELEASE_BYTES) {
            released = block->offset;
            w->content->release_pages(w->content->release_user);
        }
    }
    return result;
}

// The block table, with offsets and checksums.
stp_result stp_store_patch_blocks(stp_store_writing* w)
{
    stp_store_section* section = &w->sections[STP_SECTION_BLOCKS];
    unsigned char* bytes = STP_NEW_ARRAY(w->context, unsigned char, (size_t)section->size + 1);
    if (bytes == NULL) {
        return stp_fail_memory(w->context);
    }
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        stp_store_element element = {.block = w->plan.blocks[i]};
        result = stp_store_code_element(w, STP_SECTION_BLOCKS, i, &element,
                                        bytes + (size_t)i * section->record_size);
    }
    section->crc = stp_store_crc(0, bytes, (size_t)section->size);
    stp_store_page_sums_replace(&w->sums, STP_SECTION_BLOCKS, bytes, (size_t)section->size);
    if (result == STP_OK) {
        result = stp_file_writer_patch(w->file, section->offset, bytes, (size_t)section->size);
    }
    stp_free(w->context, bytes);
    return result;
}
