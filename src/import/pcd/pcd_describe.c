// SPDX-License-Identifier: MIT
#include "import/pcd/pcd.h"

#include <assert.h>
#include <stdio.h>

void stp_pcd_describe(const stp_import* import, const stp_pcd* pcd, const uint8_t* slots,
                      uint8_t unused, stp_scan_info* info)
{
    static const char* const types[3][4] = {
        {"u8", "u16", "u32", "u64"}, {"i8", "i16", "i32", "i64"}, {"f8", "f16", "f32", "f64"}};
    static const char* const encodings[] = {"ascii", "binary", "binary_compressed"};
    assert(pcd->field_count > 0 && pcd->field_count <= STP_PCD_FIELDS);
    *info = (stp_scan_info){.format = "pcd",
                            .point_count = pcd->point_count,
                            .scan_count = 1,
                            .point_format = -1,
                            .unit_metres = import->unit_metres,
                            .compressed = pcd->encoding == STP_PCD_COMPRESSED};
    info->record_bytes = pcd->encoding == STP_PCD_ASCII ? 0 : pcd->row_size;
    snprintf(info->version, sizeof(info->version), "%s", encodings[pcd->encoding]);
    if (info->compressed) {
        snprintf(info->compressor, sizeof(info->compressor), "LZF");
    }
    for (uint32_t i = 0; i < pcd->field_count; ++i) {
        const stp_pcd_field* f = &pcd->fields[i];
        int kind = f->type == 'U' ? 0 : f->type == 'I' ? 1 : 2;
        int size = f->size == 1 ? 0 : f->size == 2 ? 1 : f->size == 4 ? 2 : 3;
        assert((kind < 2 || size >= 2) && "floats have four bytes or eight");
        assert(f->offset + f->size * f->count <= pcd->row_size);
        stp_scan_field* added = f->name[0] == '_'
                                    ? NULL
                                    : stp_scan_add_field(info, f->name, sizeof(f->name),
                                                         types[kind][size], slots[i] != unused);
        if (added != NULL) {
            added->count = f->count;
        }
    }
}
