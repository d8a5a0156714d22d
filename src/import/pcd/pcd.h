// SPDX-License-Identifier: MIT
//
// Inside the PCD reader: the header (pcd_header.c), and values of fields (pcd_values.c).
#pragma once

#include "import/reading/import.h"
#include "import/reading/scan_info.h"
#include "import/reading/text.h"

enum { STP_PCD_FIELDS = 64 };

typedef enum stp_pcd_encoding {
    STP_PCD_ASCII,
    STP_PCD_BINARY,
    STP_PCD_COMPRESSED
} stp_pcd_encoding;

typedef struct stp_pcd_field {
    char name[32];
    char type;       ///< 'I', 'U' or 'F'
    uint32_t size;   ///< bytes: 1, 2, 4 or 8
    uint32_t count;  ///< values
    uint32_t offset; ///< within a row
} stp_pcd_field;

typedef struct stp_pcd {
    stp_pcd_field fields[STP_PCD_FIELDS];
    uint32_t field_count;
    uint32_t row_size;
    uint64_t point_count;
    stp_pcd_encoding encoding;
    size_t body;        ///< offset of the points
    uint64_t body_line; ///< its line, from 0
} stp_pcd;

/// Reads everything up to the line DATA. @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_TRUNCATED
/// (logged)
STP_MUST_USE stp_result stp_pcd_read_header(stp_import* import, stp_pcd* pcd);

/// A binary value of a field.
double stp_pcd_value(const unsigned char* at, const stp_pcd_field* f);
/// Values of a field of `count` points, `stride` bytes apart. Each loop knows the type.
void stp_pcd_read_column(const unsigned char* at, size_t stride, const stp_pcd_field* f,
                         size_t count, double* to);
/// A packed colour, 0x00RRGGBB, from the text [at, end) and its value: a whole number, or the float
/// with the same bits.
uint32_t stp_pcd_packed_color(stp_text at, stp_text end, double value);

/// Describes the points from the header. Padding fields are skipped; those whose slot is `unused`
/// are not kept.
void stp_pcd_describe(const stp_import* import, const stp_pcd* pcd, const uint8_t* slots,
                      uint8_t unused, stp_scan_info* info);
