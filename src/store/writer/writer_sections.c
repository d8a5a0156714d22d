// SPDX-License-Identifier: MIT
// Writes the sections of the directory, in file order.
#include "store/clusters/clusters_layout.h"
#include "store/sets/sets_internal.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <string.h>

// In file order: the file's description first, sections that drawing does not need last.
static const uint8_t section_order[] = {
    STP_SECTION_SUMMARY,
    STP_SECTION_SCENE_PARTS,
    STP_SECTION_VIEWS,
    STP_SECTION_SOURCES,
    STP_SECTION_COORDINATES,
    STP_SECTION_ATTRIBUTES,
    STP_SECTION_ATTRIBUTE_VALUES,
    STP_SECTION_CERTAINTY,
    STP_SECTION_LEVEL_FIGURES,
    STP_SECTION_SIDES,
    STP_SECTION_BUILD,
    STP_SECTION_NODES,
    STP_SECTION_EDGES,
    STP_SECTION_PARTS,
    STP_SECTION_MATERIALS,
    STP_SECTION_NORMAL_MAPS,
    STP_SECTION_SHADINGS,
    STP_SECTION_GROWTHS,
    STP_SECTION_TEXTURES,
    STP_SECTION_MESHES,
    STP_SECTION_POINT_SETS,
    STP_SECTION_SPLAT_SETS,
    STP_SECTION_OCTAVES,
    STP_SECTION_BREAKPOINTS,
    STP_SECTION_METHODS,
    STP_SECTION_METHOD_NODES,
    STP_SECTION_LEAVES,
    STP_SECTION_BLOCKS,
    STP_SECTION_ATTRIBUTE_BLOCKS,
    STP_SECTION_CLUSTERS,
    STP_SECTION_LEVELS,
    STP_SECTION_LEVEL_CLUSTERS,
    STP_SECTION_LEVEL_GROUPS,
    STP_SECTION_TEXT,
    STP_SECTION_OBJECTS,
    STP_SECTION_OBJECT_TEXT,
    STP_SECTION_KEYS,
    STP_SECTION_PAGES,
};

enum {
    SECTION_LIMIT = sizeof(section_order),
    MIN_PACKED = 256, ///< minimum size of a packed section
};

_Static_assert(sizeof(section_order) <= STP_SECTION_END, "each type of section is written once");

// Packs sections that are not patched, are large enough, and compress well: keys are hashes and do
// not. Temporary files are not packed.
static bool is_to_be_packed(const stp_store_writing* w, uint32_t type, uint64_t bytes)
{
    bool patched = type == STP_SECTION_SUMMARY || type == STP_SECTION_SCENE_PARTS ||
                   type == STP_SECTION_BLOCKS || type == STP_SECTION_PAGES;
    return !patched && type != STP_SECTION_KEYS && bytes >= MIN_PACKED && !w->content->passing;
}

// Sections needed to interpret the others.
static bool is_critical(uint32_t type)
{
    return type == STP_SECTION_CLUSTERS || type == STP_SECTION_METHODS ||
           type == STP_SECTION_METHOD_NODES;
}

// A section's size is known in advance. Exception: the texts of a kind follow the sections that use
// them.
static stp_result begin_section(stp_store_writing* w, uint32_t type, uint64_t count)
{
    stp_result result = stp_store_pad(w);
    uint32_t record_size = stp_store_table_of(type)->record_size;
    assert(record_size != 0 && w->packing == NULL && !w->sums.open);
    bool packed = is_to_be_packed(w, type, count * record_size);
    w->crc = 0;
    stp_store_page_sums_begin(&w->sums, type, packed);
    w->sections[type] = (stp_store_section){
        .type = type,
        .flags =
            (is_critical(type) ? STP_SECTION_CRITICAL : 0u) | (packed ? STP_SECTION_PACKED : 0u),
        .offset = stp_file_writer_size(w->file),
        .size = count * record_size,
        .count = count,
        .record_size = record_size,
    };
    if (result == STP_OK && packed) {
        result = stp_store_packing_begin(w, &w->sections[type]);
    }
    return result;
}

static stp_result end_section(stp_store_writing* w, uint32_t type, stp_result result)
{
    stp_store_section* section = &w->sections[type];
    section->crc = w->crc;
    w->sums.open = false;
    if (w->packing != NULL) {
        result = result == STP_OK ? stp_store_packing_end(w->packing) : result;
        stp_store_packing_destroy(w);
    }
    assert(result != STP_OK || stp_file_writer_size(w->file) == section->offset + section->size);
    return result;
}

// Codes one element into `bytes`, which has room for a record.
stp_result stp_store_code_element(stp_store_writing* w, uint32_t type, uint32_t index,
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

static stp_result emit_element(stp_store_writing* w, uint32_t type, uint32_t index,
                               stp_store_element* element)
{
    assert(stp_store_table_of(type)->record_size <= STP_STORE_RECORD_LIMIT);
    unsigned char bytes[STP_STORE_RECORD_LIMIT];
    stp_result result = stp_store_code_element(w, type, index, element, bytes);
    return result == STP_OK ? stp_store_emit(w, bytes, stp_store_table_of(type)->record_size)
                            : result;
}

// A table whose elements are in the content.
static stp_result write_table(stp_store_writing* w, uint32_t type, const void* elements,
                              uint32_t count)
{
    const stp_store_table* table = stp_store_table_of(type);
    stp_result result = begin_section(w, type, count);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element;
        memcpy(&element, (const char*)elements + i * table->element_size, table->element_size);
        result = emit_element(w, type, i, &element);
    }
    return end_section(w, type, result);
}

static stp_store_mesh_record make_mesh(const stp_store_writing* w, uint32_t index)
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

// Records of meshes, point sets, textures and sets: those of the content, with their block numbers.
static stp_store_element make_record(const stp_store_writing* w, uint32_t type, uint32_t index)
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
    case STP_SECTION_LEAVES:
        element.leaves.leaf_count = content->sets[index].leaf_count;
        element.leaves.block = w->plan.leaf_blocks[index];
        break;
    case STP_SECTION_GROWTHS:
        element.growth = content->directory.shadings[index].growth;
        break;
    case STP_SECTION_CERTAINTY:
        element.certainty = (stp_store_certainty){
            .flags = content->sets[index].unknown_signs ? STP_CERTAINTY_UNKNOWN_SIGNS : 0,
            .position_error = content->sets[index].position_error};
        break;
    case STP_SECTION_POINT_SETS:
        element.points.points = content->point_sets[index];
        element.points.present = element.points.points.held_by == 0
                                     ? stp_store_points_present(&content->point_sets[index])
                                     : STP_COLUMN_NORMALS | STP_COLUMN_COLORS;
        element.points.block = w->plan.point_blocks[index];
        break;
    default:
        element.texture.texture = content->textures[index];
        element.texture.block = w->plan.texture_blocks[index];
        break;
    }
    return element;
}

static stp_result write_records(stp_store_writing* w, uint32_t type, uint32_t count)
{
    stp_result result = begin_section(w, type, count);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element = make_record(w, type, i);
        result = emit_element(w, type, i, &element);
    }
    return end_section(w, type, result);
}

// A section of the sets: their records, octaves or breakpoints, in the order of the sets.
static stp_result write_sets(stp_store_writing* w, uint32_t type)
{
    uint32_t set_count = w->content->directory.set_count;
    const stp_splats* sets = w->content->sets;
    uint64_t octaves = 0, breakpoints = 0;
    for (uint32_t i = 0; i < set_count; ++i) {
        octaves += sets[i].octave_count;
        breakpoints += sets[i].table.size;
    }
    if (breakpoints >= STP_STORE_NONE) {
        return stp_fail(w->context, STP_ERROR_LIMIT, "%s: cannot hold %llu breakpoints", w->path,
                        (unsigned long long)breakpoints);
    }
    uint64_t count = type == STP_SECTION_SPLAT_SETS ? set_count
                     : type == STP_SECTION_OCTAVES  ? octaves
                                                    : breakpoints;
    stp_result result = begin_section(w, type, count);
    uint32_t octave = 0, breakpoint = 0;
    for (uint32_t i = 0; i < set_count && result == STP_OK; ++i) {
        const stp_splats* set = &sets[i];
        uint32_t records = type == STP_SECTION_SPLAT_SETS ? 1
                           : type == STP_SECTION_OCTAVES  ? set->octave_count
                                                          : set->table.size;
        for (uint32_t k = 0; k < records && result == STP_OK; ++k) {
            stp_store_element element = {0};
            if (type == STP_SECTION_SPLAT_SETS) {
                element.set.splats = *set;
                element.set.first_octave = octave;
                element.set.first_breakpoint = breakpoint;
            } else if (type == STP_SECTION_OCTAVES) {
                element.octave.end = set->octave_ends[k];
                element.octave.block = w->plan.octave_blocks[octave + k];
            } else {
                element.breakpoint.count = set->table.count[k];
                element.breakpoint.radius = set->table.radius[k];
            }
            result = emit_element(w, type, i, &element);
        }
        octave += set->octave_count;
        breakpoint += set->table.size;
    }
    assert(result != STP_OK || (octave == octaves && breakpoint == breakpoints));
    return end_section(w, type, result);
}

static stp_result write_bytes(stp_store_writing* w, uint32_t type, const void* bytes, size_t size)
{
    stp_result result = begin_section(w, type, size);
    if (result == STP_OK) {
        result = stp_store_emit(w, bytes, size);
    }
    return end_section(w, type, result);
}

static stp_result write_level_figures(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_store_level_figures figures = {.levels = d->level_count};
    for (uint32_t i = stp_store_first_level_mesh(d); i < d->mesh_count; ++i) {
        const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, i);
        assert(coded != NULL && "levels are coded");
        figures.triangles += coded->triangle_count;
        figures.bytes += coded->size;
    }
    return write_table(w, STP_SECTION_LEVEL_FIGURES, &figures, 1);
}

static stp_result write_sides(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_store_sides* records = NULL;
    stp_result result = stp_store_sides_of_content(w->context, w->content, &records);
    if (result == STP_OK) {
        result = write_table(w, STP_SECTION_SIDES, records, d->material_count + d->shading_count);
    }
    stp_free(w->context, records);
    return result;
}

static stp_result write_normal_maps(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_store_normal_map* records = NULL;
    stp_result result = stp_store_list_normal_maps(w->context, d, &records);
    if (result == STP_OK) {
        result = write_table(w, STP_SECTION_NORMAL_MAPS, records, stp_store_count_normal_maps(d));
    }
    stp_free(w->context, records);
    return result;
}

// One key per splat set, then one per mesh; no section if there are no keys.
static stp_result write_keys(stp_store_writing* w)
{
    const stp_store_content* content = w->content;
    uint32_t sets = content->directory.set_count, meshes = content->directory.mesh_count;
    bool keyed = content->set_keys != NULL || content->mesh_keys != NULL;
    uint64_t count = keyed ? (uint64_t)sets + meshes : 0;
    stp_result result = begin_section(w, STP_SECTION_KEYS, count);
    for (uint64_t i = 0; i < count && result == STP_OK; ++i) {
        stp_store_element element = {0};
        if (i < sets && content->set_keys != NULL) {
            element.key.hash = content->set_keys[i];
        } else if (i >= sets && content->mesh_keys != NULL) {
            element.key.hash = content->mesh_keys[i - sets];
        }
        result = emit_element(w, STP_SECTION_KEYS, (uint32_t)i, &element);
    }
    return end_section(w, STP_SECTION_KEYS, result);
}

static stp_result write_methods(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_result result = begin_section(w, STP_SECTION_METHODS, d->method_count);
    for (uint32_t i = 0; i < d->method_count && result == STP_OK; ++i) {
        stp_store_element element = {.method = {d->methods[i]}};
        result = emit_element(w, STP_SECTION_METHODS, i, &element);
    }
    return end_section(w, STP_SECTION_METHODS, result);
}

// The node of each set of all methods but the first.
static stp_result write_method_nodes(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    uint32_t first = d->methods[0].set_count, count = d->set_count - first;
    uint32_t* nodes = STP_NEW_ARRAY(w->context, uint32_t, (size_t)count + 1);
    if (nodes == NULL) {
        return stp_fail_memory(w->context);
    }
    for (uint32_t m = 1; m < d->method_count; ++m) {
        for (uint32_t i = 0; i < d->node_count; ++i) {
            if (d->methods[m].sets[i] != STP_STORE_NONE) {
                nodes[d->methods[m].sets[i] - first] = i;
            }
        }
    }
    stp_result result = write_table(w, STP_SECTION_METHOD_NODES, nodes, count);
    stp_free(w->context, nodes);
    return result;
}

// The content of each attribute block, in block order.
static stp_result write_attribute_blocks(stp_store_writing* w)
{
    const uint32_t type = STP_SECTION_ATTRIBUTE_BLOCKS;
    stp_result result = begin_section(w, type, w->plan.attribute_count);
    for (uint32_t i = 0; i < w->plan.block_count && result == STP_OK; ++i) {
        const stp_store_block* block = &w->plan.blocks[i];
        if (block->kind != STP_BLOCK_ATTRIBUTES && block->kind != STP_BLOCK_POINT_ATTRIBUTES) {
            continue;
        }
        stp_store_element element = {
            .attribute_block = {i, stp_store_planned_attributes(w->content, block)}};
        result = emit_element(w, type, i, &element);
    }
    return end_section(w, type, result);
}

// One per source.
static stp_result write_coordinates(stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_result result = begin_section(w, STP_SECTION_COORDINATES, d->source_count);
    for (uint32_t i = 0; i < d->source_count && result == STP_OK; ++i) {
        stp_store_element element = {.coordinates = {d->sources[i].coordinate_system}};
        result = emit_element(w, STP_SECTION_COORDINATES, i, &element);
    }
    return end_section(w, STP_SECTION_COORDINATES, result);
}

static stp_result write_section(stp_store_writing* w, uint32_t type)
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
    case STP_SECTION_GROWTHS:
        return write_records(w, type, d->shading_count);
    case STP_SECTION_LEAVES:
    case STP_SECTION_CERTAINTY:
        return write_records(w, type, d->set_count);
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
    case STP_SECTION_METHODS:
        return write_methods(w);
    case STP_SECTION_METHOD_NODES:
        return write_method_nodes(w);
    case STP_SECTION_ATTRIBUTES:
        return write_table(w, type, w->attributes, w->attribute_count);
    case STP_SECTION_ATTRIBUTE_VALUES:
        return write_table(w, type, w->attribute_values, w->attribute_value_count);
    case STP_SECTION_ATTRIBUTE_BLOCKS:
        return write_attribute_blocks(w);
    case STP_SECTION_COORDINATES:
        return write_coordinates(w);
    case STP_SECTION_LEVELS:
        return write_table(w, type, d->levels, d->level_count);
    case STP_SECTION_LEVEL_CLUSTERS:
        return write_table(w, type, d->level_clusters, d->level_cluster_count);
    case STP_SECTION_LEVEL_GROUPS:
        return write_table(w, type, d->level_groups, d->level_group_count);
    case STP_SECTION_LEVEL_FIGURES:
        return write_level_figures(w);
    case STP_SECTION_SIDES:
        return write_sides(w);
    case STP_SECTION_NORMAL_MAPS:
        return write_normal_maps(w);
    case STP_SECTION_PAGES: // reserves the space; the checksums are written when all else is
        return write_table(w, type, w->sums.crcs, (uint32_t)w->sums.count);
    default:
        return write_sets(w, type);
    }
}

// Optional sections.
static bool is_wanted(const stp_store_writing* w, uint32_t type)
{
    const stp_store_directory* d = &w->content->directory;
    bool any = false;
    switch (type) {
    case STP_SECTION_CLUSTERS:
        for (uint32_t i = 0; i < d->mesh_count; ++i) {
            any = any || stp_store_coded_mesh(w->content, i) != NULL;
        }
        return any;
    case STP_SECTION_LEAVES:
        for (uint32_t i = 0; i < d->set_count; ++i) {
            any = any || w->content->sets[i].leaf_count > 0;
        }
        return any;
    case STP_SECTION_GROWTHS:
        return stp_any_growth(d->shadings, d->shading_count);
    case STP_SECTION_CERTAINTY:
        for (uint32_t i = 0; i < d->set_count; ++i) {
            const stp_splats* set = &w->content->sets[i];
            any = any || set->unknown_signs || set->position_error > 0.0f;
        }
        return any;
    case STP_SECTION_COORDINATES:
        for (uint32_t i = 0; i < d->source_count; ++i) {
            any = any || d->sources[i].coordinate_system != NULL;
        }
        return any;
    case STP_SECTION_METHODS:
    case STP_SECTION_METHOD_NODES:
        return stp_store_lists_methods(d);
    case STP_SECTION_ATTRIBUTES:
        return w->attribute_count != 0;
    case STP_SECTION_ATTRIBUTE_VALUES:
        return w->attribute_value_count != 0;
    case STP_SECTION_ATTRIBUTE_BLOCKS:
        return w->plan.attribute_count != 0;
    case STP_SECTION_LEVELS:
    case STP_SECTION_LEVEL_CLUSTERS:
    case STP_SECTION_LEVEL_GROUPS:
    case STP_SECTION_LEVEL_FIGURES:
        return d->level_count != 0;
    case STP_SECTION_SIDES:
        return stp_store_tells_sides(d);
    case STP_SECTION_NORMAL_MAPS:
        return stp_store_count_normal_maps(d) != 0;
    default:
        return true;
    }
}

static void list_sections(stp_store_writing* w)
{
    w->section_count = 0;
    for (size_t i = 0; i < SECTION_LIMIT; ++i) {
        if (is_wanted(w, section_order[i])) {
            w->types[w->section_count++] = section_order[i];
        }
    }
}

// Reserves header and section table, and writes every section.
stp_result stp_store_write_directory(stp_store_writing* w)
{
    static const unsigned char
        zeros[STP_STORE_HEADER_BYTES + SECTION_LIMIT * STP_STORE_SECTION_BYTES] = {0};
    list_sections(w);
    stp_result result = stp_file_writer_append(
        w->file, zeros, STP_STORE_HEADER_BYTES + w->section_count * STP_STORE_SECTION_BYTES);
    for (uint32_t i = 0; i < w->section_count && result == STP_OK; ++i) {
        result = write_section(w, w->types[i]);
    }
    return result == STP_OK ? stp_store_pad(w) : result;
}
