// SPDX-License-Identifier: MIT
// Opens a file: decodes and links the directory's tables.
#include "store/file/tables.h"
#include "store/file/texture_images.h"
#include "store/reader/scene_summary.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

static stp_result read_build(stp_store* store)
{
    stp_store_text text;
    stp_result result = stp_store_read_text(store, STP_SECTION_BUILD, &text);
    store->directory.build_json = text.stored;
    return result;
}

static stp_result read_summary(stp_store* store, stp_store_text* text)
{
    stp_result result = stp_store_read_table(store, STP_SECTION_SUMMARY, text);
    if (result == STP_OK) {
        result = stp_store_read_table(store, STP_SECTION_SCENE_PARTS, text);
    }
    return result == STP_OK ? stp_store_validate_summary(store) : result;
}

static void fill_directory(stp_store* store)
{
    stp_store_directory* directory = &store->directory;
    const uint32_t* counts = store->counts;
    directory->node_count = counts[STP_SECTION_NODES];
    directory->edge_count = counts[STP_SECTION_EDGES];
    directory->part_count = counts[STP_SECTION_PARTS];
    directory->material_count = counts[STP_SECTION_MATERIALS];
    directory->shading_count = counts[STP_SECTION_SHADINGS];
    directory->texture_count = counts[STP_SECTION_TEXTURES];
    directory->mesh_count = counts[STP_SECTION_MESHES];
    directory->point_set_count = counts[STP_SECTION_POINT_SETS];
    directory->set_count = counts[STP_SECTION_SPLAT_SETS];
    directory->view_count = counts[STP_SECTION_VIEWS];
    directory->source_count = counts[STP_SECTION_SOURCES];
    directory->level_count = counts[STP_SECTION_LEVELS];
    directory->level_cluster_count = counts[STP_SECTION_LEVEL_CLUSTERS];
    directory->level_group_count = counts[STP_SECTION_LEVEL_GROUPS];
    const stp_store_section* objects = store->known[STP_SECTION_OBJECTS];
    directory->object_count = objects != NULL ? (uint32_t)objects->count : 0;
    directory->nodes = store->tables[STP_SECTION_NODES];
    directory->edges = store->tables[STP_SECTION_EDGES];
    directory->parts = store->tables[STP_SECTION_PARTS];
    directory->materials = store->tables[STP_SECTION_MATERIALS];
    directory->shadings = store->tables[STP_SECTION_SHADINGS];
    directory->views = store->tables[STP_SECTION_VIEWS];
    directory->sources = store->tables[STP_SECTION_SOURCES];
    directory->levels = store->tables[STP_SECTION_LEVELS];
    directory->level_clusters = store->tables[STP_SECTION_LEVEL_CLUSTERS];
    directory->level_groups = store->tables[STP_SECTION_LEVEL_GROUPS];
}

// Validates the records of meshes, point sets and textures; splat sets are checked when octaves
// are linked.
static stp_result check_records(const stp_store* store)
{
    stp_store_validator validator = stp_store_own_validator(store);
    const stp_store_directory* directory = &store->directory;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < directory->mesh_count && result == STP_OK; ++i) {
        result = stp_store_validate_material(&validator, "mesh", i,
                                             stp_store_describe_mesh(store, i)->material,
                                             directory->material_count);
    }
    for (uint32_t i = 0; i < directory->point_set_count && result == STP_OK; ++i) {
        result = stp_store_validate_material(&validator, "point set", i,
                                             stp_store_describe_point_set(store, i)->material,
                                             directory->material_count);
    }
    for (uint32_t i = 0; i < directory->texture_count && result == STP_OK; ++i) {
        result = stp_store_validate_texture(&validator, i, stp_store_describe_texture(store, i));
    }
    return result;
}

// Growths are a section of their own, which early readers skip.
static stp_result link_growths(stp_store* store)
{
    const float* growths = store->tables[STP_SECTION_GROWTHS];
    stp_shading* shadings = store->tables[STP_SECTION_SHADINGS];
    uint32_t count = store->counts[STP_SECTION_GROWTHS];
    if (store->known[STP_SECTION_GROWTHS] != NULL && count != store->counts[STP_SECTION_SHADINGS]) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: lists the growths of %u shadings but has %u", store->path, count,
                        store->counts[STP_SECTION_SHADINGS]);
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (!(growths[i] > -1.0f && growths[i] <= (float)STP_GROWTH_MAX)) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: shading %u: its growth is not above -1 and at most %d",
                            store->path, i, STP_GROWTH_MAX);
        }
        shadings[i].growth = growths[i];
    }
    return STP_OK;
}

static stp_result read_directory(stp_store* store)
{
    stp_store_text text;
    stp_result result = stp_store_read_text(store, STP_SECTION_TEXT, &text);
    for (uint32_t type = STP_SECTION_NODES; type <= STP_SECTION_BLOCKS && result == STP_OK;
         ++type) {
        result = stp_store_read_table(store, type, &text);
    }
    if (result == STP_OK) {
        result = read_summary(store, &text);
    }
    static const uint32_t others[] = {STP_SECTION_CLUSTERS,       STP_SECTION_ATTRIBUTE_BLOCKS,
                                      STP_SECTION_CERTAINTY,      STP_SECTION_LEVELS,
                                      STP_SECTION_LEVEL_CLUSTERS, STP_SECTION_LEVEL_GROUPS,
                                      STP_SECTION_LEVEL_FIGURES,  STP_SECTION_SIDES,
                                      STP_SECTION_GROWTHS,        STP_SECTION_NORMAL_MAPS};
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]) && result == STP_OK; ++i) {
        result = stp_store_read_table(store, others[i], &text);
    }
    if (result == STP_OK) {
        result = stp_store_read_figures(store, &text);
    }
    if (result == STP_OK) {
        result = stp_store_read_table(store, STP_SECTION_LEAVES, &text);
    }
    if (result == STP_OK) {
        result = read_build(store);
    }
    if (result == STP_OK) {
        result = link_growths(store);
    }
    if (result != STP_OK) {
        return result;
    }
    result = stp_store_link_sides(store);
    result = result == STP_OK ? stp_store_link_normal_maps(store) : result;
    if (result != STP_OK) {
        return result;
    }
    fill_directory(store);
    stp_store_validator validator = stp_store_own_validator(store);
    result = stp_store_validate_graph(&validator, &store->directory);
    if (result == STP_OK) {
        result = stp_store_read_methods(store, &text);
    }
    if (result == STP_OK) {
        result = check_records(store);
    }
    if (result == STP_OK) {
        result = stp_store_link_blocks(store);
    }
    if (result == STP_OK) {
        result = stp_store_link_levels(store);
    }
    if (result == STP_OK && !store->desc.defer_objects) {
        result = stp_store_load_objects(store);
    }
    return result;
}

stp_result stp_store_load_objects(stp_store* store)
{
    if (store->objects_ready) {
        return STP_OK;
    }
    if (store->only_summary) {
        return stp_fail(store->context, STP_ERROR_ARGUMENT, "%s: was opened only for its summary",
                        store->path);
    }
    // a retry after a failure starts again
    stp_free(store->context, store->tables[STP_SECTION_OBJECTS]);
    store->tables[STP_SECTION_OBJECTS] = NULL;
    stp_store_text text;
    stp_result result = stp_store_read_text(store, STP_SECTION_OBJECT_TEXT, &text);
    if (result == STP_OK) {
        result = stp_store_read_table(store, STP_SECTION_OBJECTS, &text);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_store_validator validator = stp_store_own_validator(store);
    stp_store_directory directory = store->directory;
    directory.objects = store->tables[STP_SECTION_OBJECTS];
    result = stp_store_validate_objects(&validator, &directory);
    if (result == STP_OK) {
        store->directory.objects = directory.objects;
        store->objects_ready = true;
    }
    return result;
}

// NULL if memory runs out, logged.
static stp_store* create_store(stp_context* context, const char* path,
                               const stp_store_open_desc* desc)
{
    size_t length = strlen(path) + 1;
    stp_store* store = STP_NEW_ZEROED(context, stp_store, 1);
    char* copy = stp_alloc(context, length);
    if (store == NULL || copy == NULL) {
        stp_free(context, store);
        stp_free(context, copy);
        (void)stp_fail_memory(context);
        return NULL;
    }
    memcpy(copy, path, length);
    store->context = context;
    store->path = copy;
    store->desc = *desc;
    store->descriptor = -1;
    return store;
}

// Reads the store's directory. Closes the store on failure.
static stp_result finish_open(stp_store* made, stp_store** store)
{
    uint64_t partial = made->desc.partial_bytes;
    made->mapped_bytes = made->file.size;
    if (partial != 0 && partial < made->file.size) {
        made->file.size = (size_t)partial;
    }
    stp_result result = stp_store_read_header(made);
    if (result == STP_OK) {
        const stp_store_section* summary = made->known[STP_SECTION_SUMMARY];
        made->only_summary = made->desc.summary_only && summary != NULL && summary->count != 0;
        result = made->only_summary ? stp_store_read_head(made) : read_directory(made);
    }
    if (result != STP_OK) {
        stp_store_close(made);
        return result;
    }
    assert(!stp_store_is_partial(made) || made->desc.accept_partial);
    if (stp_store_is_partial(made)) {
        stp_warn(made->context, "%s: ends after %zu of %llu bytes; showing the part that is there",
                 made->path, made->file.size, (unsigned long long)made->file_bytes);
    }
    *store = made;
    return STP_OK;
}

stp_result stp_store_open_with(stp_context* context, const char* path,
                               const stp_store_open_desc* desc, stp_store** store)
{
    stp_store* made = create_store(context, path, desc);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_result result = stp_file_map_open(context, path, &made->file, &made->descriptor);
    if (result != STP_OK) {
        stp_store_close(made);
        return result;
    }
    made->mapped = true;
    if (desc->summary_only) {
        stp_file_expect_random(&made->file);
    }
    return finish_open(made, store);
}

stp_result stp_store_open_memory(stp_context* context, const char* name, const void* bytes,
                                 size_t size, const stp_store_open_desc* desc, stp_store** store)
{
    assert((uintptr_t)bytes % STP_STORE_COLUMN_ALIGNMENT == 0 && "columns are used in place");
    stp_store* made = create_store(context, name, desc);
    if (made == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    made->file = (stp_mapped_file){.bytes = bytes, .size = size};
    return finish_open(made, store);
}

stp_result stp_store_open(stp_context* context, const char* path, stp_store** store)
{
    return stp_store_open_with(context, path, &(stp_store_open_desc){0}, store);
}

stp_result stp_store_open_partial(stp_context* context, const char* path, stp_store** store)
{
    return stp_store_open_with(context, path, &(stp_store_open_desc){.accept_partial = true},
                               store);
}

void stp_store_close(stp_store* store)
{
    if (store == NULL) {
        return;
    }
    stp_context* context = store->context;
    stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_SPLAT_SETS]; ++i) {
        stp_store_free_columns(context, &sets[i]);
    }
    stp_store_release_points(store);
    stp_store_release_textures(store);
    stp_store_release_leaves(store);
    for (uint32_t type = 0; type < STP_SECTION_END; ++type) {
        stp_free(context, store->tables[type]);
    }
    stp_store_free_large(store);
    stp_store_free_keys(store);
    stp_store_free_packed(store);
    stp_free(context, store->pages_checked);
    stp_free(context, store->methods);
    stp_free(context, store->method_sets);
    stp_free(context, store->attribute_blocks);
    stp_free(context, store->level_starts);
    if (store->mapped) {
        store->file.size = store->mapped_bytes;
        stp_file_unmap(&store->file);
    }
    stp_file_close(store->descriptor);
    stp_free(context, store->path);
    stp_free(context, store);
}

const stp_store_directory* stp_store_get_directory(const stp_store* store)
{
    return &store->directory;
}

uint64_t stp_store_file_bytes(const stp_store* store)
{
    return store->file.size;
}

uint64_t stp_store_whole_bytes(const stp_store* store)
{
    return store->file_bytes;
}

bool stp_store_is_partial(const stp_store* store)
{
    return store->file.size < store->file_bytes;
}

const stp_store_summary* stp_store_get_summary(const stp_store* store)
{
    return store->counts[STP_SECTION_SUMMARY] != 0 ? &store->summary : NULL;
}

const stp_store_level_figures* stp_store_get_level_figures(const stp_store* store)
{
    return store->tables[STP_SECTION_LEVEL_FIGURES];
}

uint32_t stp_store_format_minor(const stp_store* store)
{
    return store->minor;
}

uint32_t stp_store_format_version(const stp_store* store)
{
    (void)store; // all supported files have version 1
    return STP_STORE_MAJOR;
}
