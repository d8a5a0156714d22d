// SPDX-License-Identifier: MIT
// Streams a file: reserves header and section table, then writes the directory's sections and the
// blocks. Finally patches the header, section table, block table and summary, which need the sizes,
// offsets and checksums of blocks.
#include "store/writer/writer.h"

#include "base/io/bytes.h"
#include "store/bytes/packed.h"
#include "store/clusters/clusters_layout.h"
#include "store/file/content_sizes.h"
#include "store/file/texture_images.h"
#include "store/sets/sets_internal.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <string.h>

stp_result stp_store_emit(stp_store_writing* w, const void* bytes, size_t size)
{
    if (w->packing != NULL) {
        return stp_store_packing_add(w->packing, bytes, size);
    }
    w->crc = stp_store_crc(w->crc, bytes, size);
    stp_result result = stp_store_page_sums_add(&w->sums, bytes, size);
    return result == STP_OK ? stp_file_writer_append(w->file, bytes, size) : result;
}

// Zero padding up to the next multiple; not part of any checksum.
stp_result stp_store_pad(stp_store_writing* w)
{
    static const unsigned char zeros[STP_STORE_ALIGNMENT] = {0};
    uint64_t size = stp_file_writer_size(w->file);
    return stp_file_writer_append(w->file, zeros,
                                  (size_t)(stp_store_align(size, STP_STORE_ALIGNMENT) - size));
}

// Writes the page checksums, once those of the block table are known.
static stp_result patch_pages(stp_store_writing* w)
{
    stp_store_section* section = &w->sections[STP_SECTION_PAGES];
    assert(section->count == w->sums.count && !stp_store_is_packed(section));
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

// The least version that the content needs.
static uint16_t find_minor(const stp_store_content* content)
{
    const stp_store_directory* directory = &content->directory;
    for (uint32_t i = 0; i < directory->set_count; ++i) {
        if (content->sets[i].light_octaves != 0) {
            return STP_STORE_MINOR_LIT;
        }
    }
    bool growths = stp_any_growth(directory->shadings, directory->shading_count);
    bool normal_maps = stp_store_count_normal_maps(directory) != 0;
    return normal_maps                   ? STP_STORE_MINOR_NORMAL_MAPS
           : growths                     ? STP_STORE_MINOR_GROWTHS
           : directory->level_count != 0 ? STP_STORE_MINOR_LEVELS
                                         : STP_STORE_MINOR;
}

// Offsets of the fields: see docs/format.md, Header.
static stp_result patch_header(stp_store_writing* w, uint64_t data_offset)
{
    const stp_store_directory* directory = &w->content->directory;
    unsigned char bytes[STP_STORE_HEADER_BYTES + STP_SECTION_END * STP_STORE_SECTION_BYTES] = {0};
    size_t size = STP_STORE_HEADER_BYTES + w->section_count * STP_STORE_SECTION_BYTES;
    stp_store_codec codec = {.output = bytes, .offset = STP_STORE_HEADER_BYTES};
    for (uint32_t i = 0; i < w->section_count; ++i) {
        stp_store_code_section(&codec, &w->sections[w->types[i]]);
    }
    assert(codec.offset == size && data_offset % STP_STORE_ALIGNMENT == 0);
    memcpy(bytes, STP_STORE_MAGIC, STP_STORE_MAGIC_BYTES);
    stp_write_u16(bytes + 8, STP_STORE_MAJOR);
    stp_write_u16(bytes + 10, find_minor(w->content));
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

// Rejects everything that the reader would reject.
static stp_result check_content(const stp_store_writing* w)
{
    const stp_store_directory* d = &w->content->directory;
    stp_store_validator validator = {
        .context = w->context, .path = w->path, .failure = STP_ERROR_ARGUMENT};
    stp_result result = stp_store_validate_graph(&validator, d);
    result = result == STP_OK ? stp_store_validate_methods(&validator, w->content) : result;
    result = result == STP_OK ? stp_store_validate_levels(&validator, w->content) : result;
    if (result == STP_OK) {
        result = stp_store_validate_objects(&validator, d);
    }
    for (uint32_t i = 0; i < d->mesh_count && result == STP_OK; ++i) {
        const stp_store_mesh* mesh = &w->content->meshes[i];
        result =
            stp_store_validate_material(&validator, "mesh", i, mesh->material, d->material_count);
        const stp_coded_mesh* coded = stp_store_coded_mesh(w->content, i);
        if (result == STP_OK && coded == NULL) {
            result = stp_store_validate_mesh_data(&validator, i, mesh);
        } else if (result == STP_OK && coded->size < CLUSTERS_HEADER_BYTES) {
            result = stp_fail(w->context, STP_ERROR_ARGUMENT, "%s: mesh %u has too few bytes",
                              w->path, i);
        }
    }
    for (uint32_t i = 0; i < d->point_set_count && result == STP_OK; ++i) {
        const stp_store_point_set* points = &w->content->point_sets[i];
        result = stp_store_validate_material(&validator, "point set", i, points->material,
                                             d->material_count);
        if (result == STP_OK && points->held_by == 0) {
            result = stp_store_validate_point_data(&validator, i, points);
        } else if (result == STP_OK && points->held_by > d->set_count) {
            result = stp_fail(w->context, STP_ERROR_ARGUMENT,
                              "%s: point set %u: splat set %u does not exist (there are %u)",
                              w->path, i, points->held_by - 1, d->set_count);
        } else if (result == STP_OK) {
            result = stp_store_validate_held_points(&validator, i, points,
                                                    &w->content->sets[points->held_by - 1]);
        }
    }
    for (uint32_t i = 0; i < d->texture_count && result == STP_OK; ++i) {
        result = stp_store_validate_texture(&validator, i, &w->content->textures[i]);
    }
    result = result == STP_OK ? stp_store_validate_pictures(&validator, w->content) : result;
    for (uint32_t i = 0; i < d->set_count && result == STP_OK; ++i) {
        const stp_splats* splats = &w->content->sets[i];
        result = stp_store_validate_splat_set(&validator, i, splats);
        result = result == STP_OK ? stp_store_validate_leaves(&validator, i, splats) : result;
        if (result == STP_OK) {
            stp_store_splat_data data = {splats->count, splats->materials, splats->shapes,
                                         splats->ranges};
            result = stp_store_validate_splat_data(&validator, i, &data, d->shading_count);
        }
    }
    return result;
}

// Writes the summary again, with the final sizes of compressed blocks.
static stp_result patch_summary(stp_store_writing* w)
{
    stp_store_text whole = w->text;
    w->text = (stp_store_text){
        .context = w->context}; // first in the section, so texts get the same offsets again
    stp_store_summary_destroy(w->context, &w->summary);
    stp_result result = stp_store_summarise_planned(w->context, w->content, &w->plan, &w->summary);
    if (result == STP_OK) {
        result = stp_store_patch_section(w, STP_SECTION_SUMMARY, &w->summary, 1);
    }
    if (result == STP_OK) {
        result = stp_store_patch_section(w, STP_SECTION_SCENE_PARTS, w->summary.parts,
                                         w->summary.part_count);
    }
    assert(result != STP_OK || w->text.size == 0 ||
           (w->text.size <= whole.size && memcmp(w->text.bytes, whole.bytes, w->text.size) == 0));
    stp_free(w->context, w->text.bytes);
    w->text = whole;
    return result;
}

static stp_result write_all(stp_store_writing* w)
{
    stp_result result = stp_store_plan_make(w->context, w->content, 0, &w->plan);
    if (result == STP_OK) {
        result = stp_store_summarise_planned(w->context, w->content, &w->plan, &w->summary);
    }
    if (result == STP_OK) {
        result = stp_store_measure_attributes(w);
    }
    if (result == STP_OK) {
        result = stp_file_writer_open(w->context, w->path, &w->file);
    }
    if (result == STP_OK) {
        result = stp_store_write_directory(w);
    }
    if (result != STP_OK) {
        return result;
    }
    assert(w->packing == NULL && !w->sums.open && "every section has ended");
    uint64_t data_offset = stp_file_writer_size(w->file);
    result = stp_store_write_blocks(w);
    if (result == STP_OK) {
        result =
            stp_store_patch_section(w, STP_SECTION_BLOCKS, w->plan.blocks, w->plan.block_count);
    }
    if (result == STP_OK) {
        result = patch_summary(w);
    }
    if (result == STP_OK) {
        result = patch_pages(w);
    }
    if (result == STP_OK) {
        result = patch_header(w, data_offset);
    }
    if (result == STP_OK && w->content->is_intact != NULL &&
        !w->content->is_intact(w->content->release_user)) {
        result = stp_fail(w->context, STP_ERROR_IO,
                          "%s: not written, because the input changed during the build", w->path);
    }
    if (result == STP_OK) {
        stp_file_writer* file = w->file;
        w->file = NULL;
        result = w->content->passing ? stp_file_writer_commit_passing(file)
                                     : stp_file_writer_commit(file);
    }
    return result;
}

stp_result stp_store_write(stp_context* context, const stp_store_content* content, const char* path)
{
    stp_store_writing w = {
        .context = context,
        .content = content,
        .path = path,
        .text = {.context = context},
        .object_text = {.context = context},
        .sums = {.context = context},
    };
    stp_result result = check_content(&w);
    if (result == STP_OK) {
        result = write_all(&w);
    }
    stp_store_packing_destroy(&w);
    stp_file_writer_abort(w.file);
    stp_store_plan_destroy(context, &w.plan);
    stp_free(context, w.attribute_values);
    stp_free(context, w.text.bytes);
    stp_free(context, w.object_text.bytes);
    stp_store_summary_destroy(context, &w.summary);
    stp_free(context, w.sums.crcs);
    return result;
}
