// SPDX-License-Identifier: MIT
// Streams a file: a place for header and section table, the directory's sections, the blocks; then
// the header, section table and block table, whose checksums and offsets are known only now, are
// patched in.
#include "store/writer.h"

#include "base/bytes.h"
#include "store/clusters_layout.h"
#include "store/internal.h"
#include "store/matter.h"
#include "store/page_sums.h"

#include <assert.h>
#include <string.h>

// In the order of the file: first what says what the file is, last what a picture does not need.
static const uint8_t section_order[] = {
    STP_SECTION_SUMMARY,     STP_SECTION_SCENE_PARTS, STP_SECTION_VIEWS,    STP_SECTION_SOURCES,
    STP_SECTION_BUILD,       STP_SECTION_NODES,       STP_SECTION_EDGES,    STP_SECTION_PARTS,
    STP_SECTION_MATERIALS,   STP_SECTION_SHADINGS,    STP_SECTION_TEXTURES, STP_SECTION_MESHES,
    STP_SECTION_POINT_SETS,  STP_SECTION_SURFELS,     STP_SECTION_OCTAVES,  STP_SECTION_BREAKPOINTS,
    STP_SECTION_BLOCKS,      STP_SECTION_CLUSTERS,    STP_SECTION_TEXT,     STP_SECTION_OBJECTS,
    STP_SECTION_OBJECT_TEXT, STP_SECTION_KEYS,        STP_SECTION_PAGES,
};

enum { SECTION_LIMIT = sizeof(section_order) };

typedef struct writing {
    stp_context* context;
    const stp_store_content* content;
    const char* path;
    stp_file_writer* file;
    stp_store_plan plan;
    uint32_t types[SECTION_LIMIT]; ///< of the sections, as they lie in the file
    uint32_t section_count;
    stp_store_section sections[STP_SECTION_END]; ///< by type
    stp_store_text text, object_text;
    stp_store_summary summary;
    uint32_t crc; ///< of the section or block being written
    stp_store_page_sums sums;
} writing;

static stp_result emit(writing* w, const void* bytes, size_t size)
{
    w->crc = stp_store_crc(w->crc, bytes, size);
    stp_result result = stp_store_page_sums_add(&w->sums, bytes, size);
    return result == STP_OK ? stp_file_writer_append(w->file, bytes, size) : result;
}

// Zero bytes up to the next multiple; not part of any checksum.
static stp_result pad(writing* w)
{
    static const unsigned char zeros[STP_STORE_ALIGNMENT] = {0};
    uint64_t size = stp_file_writer_size(w->file);
    return stp_file_writer_append(w->file, zeros,
                                  (size_t)(stp_store_align(size, STP_STORE_ALIGNMENT) - size));
}

// Where the section will lie, and its size, are known beforehand; texts' are not, and come last of
// theirs.
static stp_result begin_section(writing* w, uint32_t type, uint64_t count)
{
    stp_result result = pad(w);
    uint32_t record_size = stp_store_table_of(type)->record_size;
    w->crc = 0;
    stp_store_page_sums_begin(&w->sums, type);
    w->sections[type] = (stp_store_section){
        .type = type,
        .flags = type == STP_SECTION_CLUSTERS ? STP_SECTION_CRITICAL : 0,
        .offset = stp_file_writer_size(w->file),
        .size = count * record_size,
        .count = count,
        .record_size = record_size,
    };
    return result;
}

static stp_result end_section(writing* w, uint32_t type, stp_result result)
{
    stp_store_section* section = &w->sections[type];
    section->crc = w->crc;
    w->sums.open = false;
    assert(result != STP_OK || stp_file_writer_size(w->file) == section->offset + section->size);
    return result;
}

// Codes one element into `bytes`, which has room for a record.
static stp_result code_element(writing* w, uint32_t type, uint32_t index,
                               stp_store_element* element, unsigned char* bytes)
{
    const stp_store_table* table = stp_store_table_of(type);
    stp_store_codec codec = {
        .output = bytes,
        .text = type == STP_SECTION_OBJECTS ? &w->object_text : &w->text,
    };
    table->code(&codec, element);
    assert(codec.offset == table->record_size);
    if (codec.result != STP_OK) {
        return stp_fail_memory(w->context);
    }
    if (codec.fault != NULL) {
        return stp_fail(w->context, STP_ERROR_ARGUMENT, "%s: %s %u %s", w->path, table->name, index,
                        codec.fault);
    }
    return STP_OK;
}

// A table whose elements are the content's own.
static stp_result write_table(writing* w, uint32_t type, const void* elements, uint32_t count)
{
    const stp_store_table* table = stp_store_table_of(type);
    stp_result result = begin_section(w, type, count);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element;
        unsigned char bytes[STP_STORE_RECORD_LIMIT];
        memcpy(&element, (const char*)elements + i * table->element_size, table->element_size);
        result = code_element(w, type, i, &element, bytes);
        if (result == STP_OK) {
            result = emit(w, bytes, table->record_size);
        }
    }
    return end_section(w, type, result);
}

static stp_store_mesh_record make_mesh(const writing* w, uint32_t index)
{
    const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, index);
    stp_store_mesh_record record = {
        .mesh = w->content->meshes[index],
        .present = stp_store_mesh_present(&w->content->meshes[index]),
        .block = w->plan.mesh_blocks[index],
    };
    if (coded != NULL) {
        record.mesh.vertex_count = coded->vertex_count;
        record.mesh.triangle_count = coded->triangle_count;
        record.mesh.bounds = coded->bounds;
        record.present = clusters_read_present(coded->bytes);
    }
    return record;
}

// The records of meshes, point sets, textures and sets: the content's, with the blocks they refer
// to.
static stp_store_element make_record(const writing* w, uint32_t type, uint32_t index)
{
    const stp_store_content* content = w->content;
    stp_store_element element = {0};
    switch (type) {
    case STP_SECTION_MESHES:
        element.mesh = make_mesh(w, index);
        break;
    case STP_SECTION_CLUSTERS: {
        const stp_coded_mesh* coded = stp_store_coded_mesh(content, index);
        element.clusters.cluster_count = coded != NULL ? coded->cluster_count : STP_STORE_NONE;
        break;
    }
    case STP_SECTION_POINT_SETS:
        element.points.points = content->point_sets[index];
        element.points.present = stp_store_points_present(&content->point_sets[index]);
        element.points.block = w->plan.point_blocks[index];
        break;
    default:
        element.texture.texture = content->textures[index];
        element.texture.block = w->plan.texture_blocks[index];
        break;
    }
    return element;
}

static stp_result write_records(writing* w, uint32_t type, uint32_t count)
{
    stp_result result = begin_section(w, type, count);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element = make_record(w, type, i);
        unsigned char bytes[STP_STORE_RECORD_LIMIT];
        result = code_element(w, type, i, &element, bytes);
        if (result == STP_OK) {
            result = emit(w, bytes, stp_store_table_of(type)->record_size);
        }
    }
    return end_section(w, type, result);
}

// One section of the sets: their records, octaves or breakpoints, which lie in the order of the
// sets.
static stp_result write_sets(writing* w, uint32_t type)
{
    uint32_t set_count = w->content->directory.surfels_count;
    const stp_surfels* sets = w->content->surfels;
    uint64_t octaves = 0, breakpoints = 0;
    for (uint32_t i = 0; i < set_count; ++i) {
        octaves += sets[i].octave_count;
        breakpoints += sets[i].table.size;
    }
    if (breakpoints >= STP_STORE_NONE) {
        return stp_fail(w->context, STP_ERROR_LIMIT, "%s: cannot hold %llu breakpoints", w->path,
                        (unsigned long long)breakpoints);
    }
    uint64_t count = type == STP_SECTION_SURFELS   ? set_count
                     : type == STP_SECTION_OCTAVES ? octaves
                                                   : breakpoints;
    stp_result result = begin_section(w, type, count);
    uint32_t octave = 0, breakpoint = 0;
    for (uint32_t i = 0; i < set_count && result == STP_OK; ++i) {
        const stp_surfels* set = &sets[i];
        uint32_t records = type == STP_SECTION_SURFELS   ? 1
                           : type == STP_SECTION_OCTAVES ? set->octave_count
                                                         : set->table.size;
        for (uint32_t k = 0; k < records && result == STP_OK; ++k) {
            stp_store_element element = {0};
            unsigned char bytes[STP_STORE_RECORD_LIMIT];
            if (type == STP_SECTION_SURFELS) {
                element.surfels.surfels = *set;
                element.surfels.first_octave = octave;
                element.surfels.first_breakpoint = breakpoint;
            } else if (type == STP_SECTION_OCTAVES) {
                element.octave.end = set->octave_ends[k];
                element.octave.block = w->plan.octave_blocks[octave + k];
            } else {
                element.breakpoint.count = set->table.count[k];
                element.breakpoint.radius = set->table.radius[k];
            }
            result = code_element(w, type, i, &element, bytes);
            if (result == STP_OK) {
                result = emit(w, bytes, stp_store_table_of(type)->record_size);
            }
        }
        octave += set->octave_count;
        breakpoint += set->table.size;
    }
    return end_section(w, type, result);
}

static stp_result write_bytes(writing* w, uint32_t type, const void* bytes, size_t size)
{
    stp_result result = begin_section(w, type, size);
    if (result == STP_OK) {
        result = emit(w, bytes, size);
    }
    return end_section(w, type, result);
}

// One for each surfel set, then one for each mesh; none at all where nobody has one.
static stp_result write_keys(writing* w)
{
    const stp_store_content* content = w->content;
    uint32_t sets = content->directory.surfels_count, meshes = content->directory.mesh_count;
    bool keyed = content->surfel_keys != NULL || content->mesh_keys != NULL;
    uint64_t count = keyed ? (uint64_t)sets + meshes : 0;
    stp_result result = begin_section(w, STP_SECTION_KEYS, count);
    for (uint64_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element = {0};
        unsigned char bytes[STP_STORE_RECORD_LIMIT];
        if (i < sets && content->surfel_keys != NULL) {
            element.key.hash = content->surfel_keys[i];
        } else if (i >= sets && content->mesh_keys != NULL) {
            element.key.hash = content->mesh_keys[i - sets];
        }
        result = code_element(w, STP_SECTION_KEYS, (uint32_t)i, &element, bytes);
        if (result == STP_OK) {
            result = emit(w, bytes, stp_store_table_of(STP_SECTION_KEYS)->record_size);
        }
    }
    return end_section(w, STP_SECTION_KEYS, result);
}

static stp_result write_section(writing* w, uint32_t type)
{
    const stp_store_directory* d = &w->content->directory;
    switch (type) {
    case STP_SECTION_NODES:
        return write_table(w, type, d->nodes, d->node_count);
    case STP_SECTION_EDGES:
        return write_table(w, type, d->edges, d->edge_count);
    case STP_SECTION_PARTS:
        return write_table(w, type, d->parts, d->part_count);
    case STP_SECTION_MATERIALS:
        return write_table(w, type, d->materials, d->material_count);
    case STP_SECTION_SHADINGS:
        return write_table(w, type, d->shadings, d->shading_count);
    case STP_SECTION_TEXTURES:
        return write_records(w, type, d->texture_count);
    case STP_SECTION_MESHES:
    case STP_SECTION_CLUSTERS:
        return write_records(w, type, d->mesh_count);
    case STP_SECTION_POINT_SETS:
        return write_records(w, type, d->point_set_count);
    case STP_SECTION_VIEWS:
        return write_table(w, type, d->views, d->view_count);
    case STP_SECTION_SOURCES:
        return write_table(w, type, d->sources, d->source_count);
    case STP_SECTION_BLOCKS:
        return write_table(w, type, w->plan.blocks, w->plan.block_count);
    case STP_SECTION_TEXT:
        return write_bytes(w, type, w->text.bytes, w->text.size);
    case STP_SECTION_BUILD:
        return write_bytes(w, type, d->build_json,
                           d->build_json != NULL ? strlen(d->build_json) + 1 : 0);
    case STP_SECTION_OBJECTS:
        return write_table(w, type, d->objects, d->object_count);
    case STP_SECTION_OBJECT_TEXT:
        return write_bytes(w, type, w->object_text.bytes, w->object_text.size);
    case STP_SECTION_SUMMARY:
        return write_table(w, type, &w->summary, 1);
    case STP_SECTION_SCENE_PARTS:
        return write_table(w, type, w->summary.parts, w->summary.part_count);
    case STP_SECTION_KEYS:
        return write_keys(w);
    case STP_SECTION_PAGES: // what is written now is patched at the end
        return write_table(w, type, w->sums.crcs, (uint32_t)w->sums.count);
    default:
        return write_sets(w, type);
    }
}

// Those of clusters only where there are any: before texts and objects, which readers may leave for later.
static void list_sections(writing* w)
{
    bool any_coded = false;
    for (uint32_t i = 0; i < w->content->directory.mesh_count; ++i) {
        any_coded = any_coded || stp_store_coded_mesh(w->content, i) != NULL;
    }
    w->section_count = 0;
    for (size_t i = 0; i < SECTION_LIMIT; ++i) {
        if (section_order[i] != STP_SECTION_CLUSTERS || any_coded) {
            w->types[w->section_count++] = section_order[i];
        }
    }
}

// Reserves header and section table, and writes every section.
static stp_result write_directory(writing* w)
{
    static const unsigned char
        zeros[STP_STORE_HEADER_BYTES + SECTION_LIMIT * STP_STORE_SECTION_BYTES] = {0};
    list_sections(w);
    stp_result result = stp_file_writer_append(
        w->file, zeros, STP_STORE_HEADER_BYTES + w->section_count * STP_STORE_SECTION_BYTES);
    for (uint32_t i = 0; i < w->section_count && result == STP_OK; ++i) {
        result = write_section(w, w->types[i]);
    }
    return result == STP_OK ? pad(w) : result;
}

typedef struct source_column {
    const void* bytes; ///< where the column's run begins in the content
} source_column;

// Writes a block's columns, zero bytes between them.
static stp_result write_columns(writing* w, const source_column* sources,
                                const stp_store_column columns[STP_STORE_COLUMN_LIMIT],
                                size_t count)
{
    static const unsigned char zeros[STP_STORE_COLUMN_ALIGNMENT] = {0};
    uint64_t end = 0;
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        result = emit(w, zeros, (size_t)(columns[i].offset - end));
        if (result == STP_OK && columns[i].size != 0) {
            result = emit(w, sources[i].bytes, (size_t)columns[i].size);
        }
        end = columns[i].offset + columns[i].size;
    }
    return result;
}

static stp_result write_mesh(writing* w, uint32_t index)
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

static stp_result write_points(writing* w, uint32_t index)
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

static stp_result write_octave(writing* w, uint32_t index, uint32_t octave)
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
static stp_result write_clusters(writing* w, uint32_t index)
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
    return emit(w, coded->bytes, coded->size);
}

static stp_result write_block(writing* w, const stp_store_block* block)
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
        return emit(w, w->content->textures[block->owner].texels, (size_t)block->size);
    }
}

static stp_result write_blocks(writing* w)
{
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        stp_store_block* block = &w->plan.blocks[i];
        result = pad(w);
        assert(result != STP_OK || stp_file_writer_size(w->file) == block->offset);
        w->crc = 0;
        if (result == STP_OK) {
            result = write_block(w, block);
        }
        block->crc = w->crc;
        assert(result != STP_OK || stp_file_writer_size(w->file) == block->offset + block->size);
    }
    return result;
}

// The block table, with offsets and checksums.
static stp_result patch_blocks(writing* w)
{
    stp_store_section* section = &w->sections[STP_SECTION_BLOCKS];
    unsigned char* bytes = STP_NEW_ARRAY(w->context, unsigned char, (size_t)section->size + 1);
    if (bytes == NULL) {
        return stp_fail_memory(w->context);
    }
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        stp_store_element element = {.block = w->plan.blocks[i]};
        result = code_element(w, STP_SECTION_BLOCKS, i, &element,
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

// The pages' checksums, now that those of the block table are known.
static stp_result patch_pages(writing* w)
{
    stp_store_section* section = &w->sections[STP_SECTION_PAGES];
    unsigned char* bytes = STP_NEW_ARRAY(w->context, unsigned char, (size_t)section->size + 1);
    if (bytes == NULL) {
        return stp_fail_memory(w->context);
    }
    for (size_t i = 0; i < w->sums.count; ++i) {
        stp_write_u32(bytes + i * section->record_size, w->sums.crcs[i]);
    }
    section->crc = stp_store_crc(0, bytes, (size_t)section->size);
    stp_result result =
        stp_file_writer_patch(w->file, section->offset, bytes, (size_t)section->size);
    stp_free(w->context, bytes);
    return result;
}

// Offsets of the fields are those of docs/format.md, Header.
static stp_result patch_header(writing* w, uint64_t data_offset)
{
    const stp_store_directory* directory = &w->content->directory;
    unsigned char bytes[STP_STORE_HEADER_BYTES + SECTION_LIMIT * STP_STORE_SECTION_BYTES] = {0};
    size_t size = STP_STORE_HEADER_BYTES + w->section_count * STP_STORE_SECTION_BYTES;
    stp_store_codec codec = {.output = bytes, .offset = STP_STORE_HEADER_BYTES};
    for (uint32_t i = 0; i < w->section_count; ++i) {
        stp_store_code_section(&codec, &w->sections[w->types[i]]);
    }
    memcpy(bytes, STP_STORE_MAGIC, STP_STORE_MAGIC_BYTES);
    stp_write_u16(bytes + 8, STP_STORE_MAJOR);
    stp_write_u16(bytes + 10, STP_STORE_MINOR);
    stp_write_u32(bytes + 12, STP_STORE_HEADER_BYTES);
    stp_write_u64(bytes + 16, stp_file_writer_size(w->file));
    stp_write_u64(bytes + 24, data_offset);
    stp_write_u32(bytes + 32, w->section_count);
    stp_write_u32(bytes + 36,
                  stp_store_crc(0, bytes + STP_STORE_HEADER_BYTES, size - STP_STORE_HEADER_BYTES));
    stp_write_u32(bytes + 40, directory->root);
    stp_write_f64(bytes + 48, directory->unit_metres);
    bytes[56] = (unsigned char)directory->up;
    stp_write_u32(bytes + 124, stp_store_crc(0, bytes, 124));
    return stp_file_writer_patch(w->file, 0, bytes, size);
}

// Whatever the reader would refuse is refused here.
static stp_result judge_content(const writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_store_judge judge = {w->context, w->path, STP_ERROR_ARGUMENT};
    stp_result result = stp_store_judge_graph(&judge, d);
    if (result == STP_OK) {
        result = stp_store_judge_objects(&judge, d);
    }
    for (uint32_t i = 0; i < d->mesh_count && result == STP_OK; ++i) {
        const stp_store_mesh* mesh = &w->content->meshes[i];
        result = stp_store_judge_material(&judge, "mesh", i, mesh->material, d->material_count);
        const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, i);
        if (result == STP_OK && coded == NULL) {
            result = stp_store_judge_mesh_data(&judge, i, mesh);
        } else if (result == STP_OK && coded->size < CLUSTERS_HEADER_BYTES) {
            result = stp_fail(w->context, STP_ERROR_ARGUMENT, "%s: mesh %u has too few bytes",
                              w->path, i);
        }
    }
    for (uint32_t i = 0; i < d->point_set_count && result == STP_OK; ++i) {
        const stp_store_point_set* points = &w->content->point_sets[i];
        result =
            stp_store_judge_material(&judge, "point set", i, points->material, d->material_count);
        if (result == STP_OK) {
            result = stp_store_judge_point_data(&judge, i, points);
        }
    }
    for (uint32_t i = 0; i < d->texture_count && result == STP_OK; ++i) {
        result = stp_store_judge_texture(&judge, i, &w->content->textures[i]);
    }
    for (uint32_t i = 0; i < d->surfels_count && result == STP_OK; ++i) {
        const stp_surfels* surfels = &w->content->surfels[i];
        result = stp_store_judge_surfels(&judge, i, surfels);
        if (result == STP_OK) {
            result = stp_store_judge_surfel_data(&judge, i, surfels->materials, surfels->count,
                                                 d->shading_count);
        }
    }
    return result;
}

static stp_result write_all(writing* w)
{
    stp_result result = stp_store_plan_make(w->context, w->content, 0, &w->plan);
    if (result == STP_OK) {
        result = stp_store_summarise_planned(w->context, w->content, &w->plan, &w->summary);
    }
    if (result == STP_OK) {
        result = stp_file_writer_open(w->context, w->path, &w->file);
    }
    if (result == STP_OK) {
        result = write_directory(w);
    }
    if (result != STP_OK) {
        return result;
    }
    // offsets were planned from 0 on; now it is known where the blocks begin
    uint64_t data_offset = stp_file_writer_size(w->file);
    for (uint32_t i = 0; i < w->plan.block_count; ++i) {
        w->plan.blocks[i].offset += data_offset;
    }
    result = write_blocks(w);
    if (result == STP_OK) {
        result = patch_blocks(w);
    }
    if (result == STP_OK) {
        result = patch_pages(w);
    }
    if (result == STP_OK) {
        result = patch_header(w, data_offset);
    }
    if (result == STP_OK) {
        stp_file_writer* file = w->file;
        w->file = NULL;
        result = stp_file_writer_commit(file);
    }
    return result;
}

stp_result stp_store_write(stp_context* context, const stp_store_content* content, const char* path)
{
    writing w = {
        .context = context,
        .content = content,
        .path = path,
        .text = {.context = context},
        .object_text = {.context = context},
        .sums = {.context = context},
    };
    stp_result result = judge_content(&w);
    if (result == STP_OK) {
        result = write_all(&w);
    }
    stp_file_writer_abort(w.file);
    stp_store_plan_destroy(context, &w.plan);
    stp_free(context, w.text.bytes);
    stp_free(context, w.object_text.bytes);
    stp_store_summary_destroy(context, &w.summary);
    stp_free(context, w.sums.crcs);
    return result;
}
