// SPDX-License-Identifier: MIT
// Describes a LAS, LAZ or COPC file from its header, VLRs and chunk table, without reading points.
#include "base/io/bytes.h"
#include "import/las/laz.h"
#include "import/reading/scan_info.h"

#include <stipple/attributes.h>

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum {
    EXTRA_ID = 4,
    EXTRA_SIZE = 192, // bytes of an entry
    EXTRA_TYPE = 2,
    EXTRA_OPTIONS = 3,
    EXTRA_NAME = 4,
    EXTRA_NAME_SIZE = 32,
    EXTRA_TYPES = 10,
    LAZ_ID = 22204
};

static void add(stp_scan_info* info, const char* name, const char* type)
{
    (void)stp_scan_add_field(info, name, STP_SCAN_NAME, type, true);
}

static void add_kept(stp_scan_info* info, stp_attribute attribute, const char* type)
{
    add(info, stp_attribute_name(attribute), type);
}

static void add_fields(const stp_las* las, stp_scan_info* info)
{
    bool newer = las->format >= 6;
    add(info, "x", "i32");
    add(info, "y", "i32");
    add(info, "z", "i32");
    add_kept(info, STP_ATTRIBUTE_INTENSITY, "u16");
    add_kept(info, STP_ATTRIBUTE_RETURN, newer ? "4 bits" : "3 bits");
    add_kept(info, STP_ATTRIBUTE_RETURNS, newer ? "4 bits" : "3 bits");
    (void)stp_scan_add_field(info, "flags", STP_SCAN_NAME, newer ? "8 bits" : "5 bits", false);
    add_kept(info, STP_ATTRIBUTE_CLASS, newer ? "u8" : "5 bits");
    add_kept(info, STP_ATTRIBUTE_SCAN_ANGLE, newer ? "i16" : "i8");
    (void)stp_scan_add_field(info, "user data", STP_SCAN_NAME, "u8", false);
    add_kept(info, STP_ATTRIBUTE_SOURCE, "u16");
    if (las->layout.time != STP_LAS_NO_FIELD) {
        add_kept(info, STP_ATTRIBUTE_TIME, "f64");
    }
    if (las->layout.rgb != STP_LAS_NO_FIELD) {
        add(info, "red", "u16");
        add(info, "green", "u16");
        add(info, "blue", "u16");
    }
    if (las->layout.nir != STP_LAS_NO_FIELD) {
        add_kept(info, STP_ATTRIBUTE_NEAR_INFRARED, "u16");
    }
    if (las->layout.wave != STP_LAS_NO_FIELD) {
        (void)stp_scan_add_field(info, "wave packet", STP_SCAN_NAME, "29 bytes", false);
    }
}

static void add_extra(const stp_las* las, stp_scan_info* info)
{
    static const char* const types[EXTRA_TYPES + 1] = {"bytes", "u8",  "i8",  "u16", "i16", "u32",
                                                       "i32",   "u64", "i64", "f32", "f64"};
    static const uint8_t sizes[EXTRA_TYPES + 1] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    assert(las->record_size >= las->layout.size);
    size_t left = las->record_size - las->layout.size;
    stp_las_record record = {0};
    uint64_t count = 0;
    if (stp_las_find_record(las, "LASF_Spec", EXTRA_ID, &record)) {
        count = record.size / EXTRA_SIZE;
    }
    for (uint64_t i = 0; i < count && left > 0; ++i) {
        const unsigned char* at = record.bytes + i * EXTRA_SIZE;
        unsigned type = at[EXTRA_TYPE];
        bool known = type >= 1 && type <= 3 * EXTRA_TYPES; // from 11 on: two or three values
        unsigned base = known ? (type - 1) % EXTRA_TYPES + 1 : 0;
        unsigned values = known ? (type - 1) / EXTRA_TYPES + 1 : at[EXTRA_OPTIONS];
        size_t size = (size_t)values * sizes[base];
        left -= size < left ? size : left;
        assert(base <= EXTRA_TYPES && left <= las->record_size - las->layout.size);
        stp_scan_field* f = stp_scan_add_field(info, (const char*)at + EXTRA_NAME, EXTRA_NAME_SIZE,
                                               types[base], false);
        if (f != NULL) {
            f->count = values;
            f->extra = true;
        }
    }
    stp_scan_field* rest =
        left > 0 ? stp_scan_add_field(info, "undocumented", STP_SCAN_NAME, "bytes", false) : NULL;
    if (rest != NULL) {
        rest->count = (uint32_t)left;
        rest->extra = true;
    }
}

static void describe_chunks(const stp_las* las, stp_scan_info* info)
{
    static const char* const names[] = {"none", "pointwise", "pointwise, chunked",
                                        "layered, chunked"};
    stp_las_record vlr;
    info->chunk_count = las->chunk_count;
    for (size_t i = 0; i < las->chunk_count; ++i) {
        uint64_t count = las->chunks[i].count;
        info->chunk_points = count > info->chunk_points ? count : info->chunk_points;
    }
    if (stp_las_find_record(las, "laszip encoded", LAZ_ID, &vlr) && vlr.size >= 8) {
        unsigned method = stp_read_u16(vlr.bytes);
        snprintf(info->compressor, sizeof(info->compressor), "LASzip %u.%u, %s", vlr.bytes[4],
                 vlr.bytes[5], method < 4 ? names[method] : "unknown");
    }
}

stp_result stp_las_describe(stp_las* las, stp_scan_info* info)
{
    stp_result result = las->compressed ? stp_laz_read_table(las) : STP_OK;
    if (result != STP_OK) {
        return result;
    }
    *info = (stp_scan_info){.format = "las",
                            .alone = true,
                            .point_count = las->point_count,
                            .scan_count = 1,
                            .point_format = (int)las->format,
                            .record_bytes = (uint32_t)las->record_size,
                            .has_box = las->point_count > 0,
                            .has_steps = true,
                            .unit_metres = las->import->unit_metres,
                            .compressed = las->compressed};
    snprintf(info->version, sizeof(info->version), "1.%u", las->minor);
    memcpy(info->low, las->low, sizeof(info->low));
    memcpy(info->high, las->high, sizeof(info->high));
    memcpy(info->scale, las->scale, sizeof(info->scale));
    memcpy(info->offset, las->offset, sizeof(info->offset));
    for (int i = 0; i < 3; ++i) {
        info->has_box = info->has_box && info->low[i] <= info->high[i];
    }
    add_fields(las, info);
    add_extra(las, info);
    if (las->compressed) {
        describe_chunks(las, info);
    }
    stp_las_describe_copc(las, info);
    return STP_OK;
}
