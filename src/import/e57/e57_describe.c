// SPDX-License-Identifier: MIT
// Describes an E57 file from its XML section, without reading a record.
#include "import/e57/e57.h"
#include "import/reading/scan_info.h"

#include <stdio.h>
#include <string.h>

static bool text_is(const stp_e57_text* text, const char* word)
{
    size_t length = strlen(word);
    return text != NULL && text->length == length && memcmp(text->bytes, word, length) == 0;
}

static const char* type_of(const stp_e57_node* field)
{
    const stp_e57_text* type = stp_e57_attribute_of(field, "type");
    if (text_is(type, "Float")) {
        return text_is(stp_e57_attribute_of(field, "precision"), "single") ? "f32" : "f64";
    }
    return text_is(type, "ScaledInteger") ? "scaled integer"
           : text_is(type, "Integer")     ? "integer"
                                          : "string";
}

static bool has_field(const stp_scan_info* info, const char* name)
{
    for (uint32_t i = 0; i < info->field_count; ++i) {
        if (strncmp(info->fields[i].name, name, STP_SCAN_NAME - 1) == 0) {
            return true;
        }
    }
    return false;
}

// Fields of all scans, each once.
static void add_fields(const stp_e57_node* prototype, stp_scan_info* info)
{
    bool spherical = stp_e57_child(prototype, "cartesianX") == NULL;
    const stp_e57_node* f = prototype != NULL ? prototype->first : NULL;
    for (; f != NULL; f = f->next) {
        if (!has_field(info, f->name)) {
            (void)stp_scan_add_field(info, f->name, STP_SCAN_NAME, type_of(f),
                                     stp_e57_keeps(f->name, spherical));
        }
    }
}

stp_result stp_e57_describe(stp_e57* e57, stp_scan_info* info)
{
    *info = (stp_scan_info){
        .format = "e57", .point_format = -1, .unit_metres = e57->import->unit_metres};
    int64_t major = 1, minor = 0;
    const stp_e57_node* version = stp_e57_child(e57->root, "versionMajor");
    (void)stp_e57_integer(version != NULL ? &version->text : NULL, &major);
    version = stp_e57_child(e57->root, "versionMinor");
    (void)stp_e57_integer(version != NULL ? &version->text : NULL, &minor);
    snprintf(info->version, sizeof(info->version), "%lld.%lld", (long long)major, (long long)minor);
    uint32_t number = 0;
    const stp_e57_node* scans = stp_e57_child(e57->root, "data3D");
    for (const stp_e57_node* s = scans != NULL ? scans->first : NULL; s != NULL; s = s->next) {
        stp_e57_scan scan;
        stp_result result = stp_e57_describe_scan(e57, s, ++number, &scan);
        if (result != STP_OK) {
            return result;
        }
        info->scan_count += 1;
        info->point_count += scan.has_places ? scan.record_count : 0;
        add_fields(stp_e57_child(stp_e57_child(s, "points"), "prototype"), info);
    }
    return STP_OK;
}
