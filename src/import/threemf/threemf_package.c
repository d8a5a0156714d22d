// SPDX-License-Identifier: MIT
// Finds the model of a 3MF package that has the build: the start part, which _rels/.rels names (Open
// Packaging Conventions).
#include "import/reading/xml_reading.h"
#include "import/threemf/threemf.h"

#include <assert.h>
#include <limits.h>
#include <string.h>

typedef struct start_part {
    stp_xml_reading xml;
    stp_arena* text;
    const char* target; ///< NULL: none so far
    bool no_memory;
} start_part;

static bool ends_with(const char* text, size_t length, const char* suffix)
{
    size_t size = strlen(suffix);
    return length > size && memcmp(text + length - size, suffix, size) == 0;
}

static void XMLCALL begin_element(void* user, const XML_Char* name, const XML_Char** attributes)
{
    start_part* start = user;
    const char *type = "", *target = NULL;
    if (start->target != NULL || strcmp(stp_xml_local_name(name), "Relationship") != 0) {
        return;
    }
    for (; *attributes != NULL; attributes += 2) {
        type = strcmp(attributes[0], "Type") == 0 ? attributes[1] : type;
        target = strcmp(attributes[0], "Target") == 0 ? attributes[1] : target;
    }
    if (target != NULL && ends_with(type, strlen(type), "/3dmodel")) {
        start->target = stp_arena_copy_text(start->text, target, strlen(target));
        start->no_memory = start->target == NULL;
    }
}

// The entry of the start part; NULL if no relationship that can be read names one.
static stp_result find_start(stp_3mf* m, const stp_zip_entry** found)
{
    const stp_zip_entry* entry = stp_zip_find(&m->zip, "_rels/.rels");
    unsigned char* bytes;
    size_t size;
    const char* reason;
    *found = NULL;
    if (entry == NULL) {
        return STP_OK;
    }
    stp_result result = stp_zip_unpack(&m->zip, entry, &bytes, &size, &reason);
    if (result != STP_OK) {
        return result == STP_ERROR_OUT_OF_MEMORY ? result : STP_OK;
    }
    start_part start = {.xml.parser = XML_ParserCreate(NULL), .text = &m->import->scene->text};
    start.no_memory = start.xml.parser == NULL;
    if (start.xml.parser != NULL && size <= INT_MAX) {
        stp_xml_begin(&start.xml);
        XML_SetStartElementHandler(start.xml.parser, begin_element);
        if (XML_Parse(start.xml.parser, (const char*)bytes, (int)size, XML_TRUE) != XML_STATUS_OK) {
            start.no_memory |= XML_GetErrorCode(start.xml.parser) == XML_ERROR_NO_MEMORY;
        }
    }
    if (start.xml.parser != NULL) {
        XML_ParserFree(start.xml.parser);
    }
    stp_free(m->context, bytes);
    *found = start.target != NULL ? stp_zip_find(&m->zip, start.target) : NULL;
    return start.no_memory ? stp_fail_memory(m->context) : STP_OK;
}

static stp_result add_model(stp_3mf* m, const stp_zip_entry* entry, uint32_t* model)
{
    size_t slash = entry->name_length > 0 && entry->name[0] == '/';
    const char* path = stp_arena_copy_text(&m->import->scene->text, entry->name + slash,
                                           entry->name_length - slash);
    return path != NULL ? stp_3mf_find_model(m, path, model) : stp_fail_memory(m->context);
}

stp_result stp_3mf_find_root(stp_3mf* m)
{
    const stp_zip_entry* entry;
    stp_result result = find_start(m, &entry);
    if (result != STP_OK) {
        return result;
    }
    m->root = STP_NONE;
    entry = entry != NULL ? entry : stp_zip_find(&m->zip, "3D/3dmodel.model");
    if (entry != NULL) {
        return add_model(m, entry, &m->root);
    }
    for (size_t i = 0; i < m->zip.count && result == STP_OK; ++i) {
        uint32_t model;
        entry = &m->zip.entries[i];
        if (ends_with(entry->name, entry->name_length, ".model")) {
            result = add_model(m, entry, &model);
        }
    }
    return result == STP_OK && m->model_count == 0
               ? stp_fail(m->context, STP_ERROR_FORMAT, "%s: has no model in its archive",
                          m->import->path)
               : result;
}
