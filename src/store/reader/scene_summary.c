// SPDX-License-Identifier: MIT
// Reads a file's description from its first pages: summary, scene parts, views, sources,
// parameters.
#include "store/reader/scene_summary.h"

#include "store/file/tables.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

stp_result stp_store_validate_summary(stp_store* store)
{
    const stp_store_section* objects = store->known[STP_SECTION_OBJECTS];
    uint64_t object_count = objects != NULL ? objects->count : 0;
    uint32_t summaries = store->counts[STP_SECTION_SUMMARY];
    uint32_t parts = store->counts[STP_SECTION_SCENE_PARTS];
    if (summaries > 1 || parts > STP_STORE_SCENE_PARTS + 1 || (summaries == 0 && parts != 0)) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: has %u summaries and %u scene parts, expected one and at most %d",
                        store->path, summaries, parts, STP_STORE_SCENE_PARTS + 1);
    }
    if (summaries == 0) {
        return STP_OK;
    }
    store->summary = *(const stp_store_summary*)store->tables[STP_SECTION_SUMMARY];
    store->summary.parts = store->tables[STP_SECTION_SCENE_PARTS];
    store->summary.part_count = parts;
    for (uint32_t i = 0; i < parts; ++i) {
        uint32_t object = store->summary.parts[i].object;
        if (object != STP_STORE_NONE && object >= object_count) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: scene part %u: object %u does not exist (there are %llu)",
                            store->path, i, object, (unsigned long long)object_count);
        }
    }
    return STP_OK;
}

static stp_result verify_texts(stp_store* store)
{
    const stp_store_directory* d = &store->directory;
    stp_store_text uses = {.context = store->context};
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < store->summary.part_count; ++i) {
        result =
            stp_store_verify_text(store, STP_SECTION_TEXT, &uses, store->summary.parts[i].name);
    }
    for (uint32_t i = 0; result == STP_OK && i < d->method_count; ++i) {
        bool has_methods = store->known[STP_SECTION_METHODS] != NULL;
        const char* name = has_methods ? d->methods[i].name : NULL;
        result = stp_store_verify_text(store, STP_SECTION_TEXT, &uses, name);
    }
    for (uint32_t i = 0; result == STP_OK && i < d->view_count; ++i) {
        result = stp_store_verify_text(store, STP_SECTION_TEXT, &uses, d->views[i].name);
    }
    for (uint32_t i = 0; result == STP_OK && i < d->source_count; ++i) {
        result = stp_store_verify_text(store, STP_SECTION_TEXT, &uses, d->sources[i].path);
        result = result == STP_OK
                     ? stp_store_verify_text(store, STP_SECTION_TEXT, &uses, d->sources[i].format)
                     : result;
        const char* coordinates = d->sources[i].coordinate_system;
        result = result == STP_OK
                     ? stp_store_verify_text(store, STP_SECTION_TEXT, &uses, coordinates)
                     : result;
    }
    return result;
}

stp_result stp_store_read_head(stp_store* store)
{
    static const uint32_t types[] = {
        STP_SECTION_SUMMARY,   STP_SECTION_SCENE_PARTS,   STP_SECTION_VIEWS, STP_SECTION_SOURCES,
        STP_SECTION_CERTAINTY, STP_SECTION_LEVEL_FIGURES, STP_SECTION_SIDES};
    const stp_store_section* texts = store->known[STP_SECTION_TEXT];
    stp_store_text text = {.context = store->context};
    assert(store->only_summary && "stores opened for their summary");
    if (texts != NULL && texts->record_size != 1) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: texts have records of %u bytes, expected 1", store->path,
                        texts->record_size);
    }
    stp_result result = STP_OK;
    if (texts != NULL) { // verified on use
        const unsigned char* content = NULL;
        result = stp_store_find_content(store, texts, &content);
        text.stored = (const char*)content;
        text.size = (size_t)stp_store_content_bytes(texts);
    }
    for (size_t i = 0; result == STP_OK && i < sizeof(types) / sizeof(types[0]); ++i) {
        result = stp_store_read_table(store, types[i], &text);
    }
    result = result == STP_OK ? stp_store_validate_summary(store) : result;
    result = result == STP_OK ? stp_store_validate_certainty(store) : result;
    result = result == STP_OK ? stp_store_validate_level_figures(store) : result;
    result = result == STP_OK ? stp_store_validate_sides(store) : result;
    result = result == STP_OK ? stp_store_read_figures(store, &text) : result;
    result = result == STP_OK ? stp_store_read_method_names(store, &text) : result;
    result = result == STP_OK ? stp_store_read_text(store, STP_SECTION_BUILD, &text) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_store_directory* directory = &store->directory;
    directory->build_json = text.stored;
    directory->views = store->tables[STP_SECTION_VIEWS];
    directory->view_count = store->counts[STP_SECTION_VIEWS];
    directory->sources = store->tables[STP_SECTION_SOURCES];
    directory->source_count = store->counts[STP_SECTION_SOURCES];
    directory->root = STP_STORE_NONE; // the graph is not read
    stp_store_validator validator = stp_store_own_validator(store);
    result = stp_store_validate_graph(&validator, directory);
    return result == STP_OK ? verify_texts(store) : result;
}

stp_result stp_store_check_head(stp_store* store)
{
    stp_result result = stp_store_verify_page_table(store);
    for (uint32_t i = 0; result == STP_OK && i < store->section_count; ++i) {
        const stp_store_section* section = &store->sections[i];
        uint64_t first =
            section->size < STP_STORE_PAGE_BYTES ? section->size : STP_STORE_PAGE_BYTES;
        if (stp_store_is_packed(section)) {
            result = stp_store_check_packed(store, section, 1);
        } else if (section->type != STP_SECTION_PAGES) {
            result = stp_store_verify_range(store, section, 0, first);
        }
    }
    return result;
}
