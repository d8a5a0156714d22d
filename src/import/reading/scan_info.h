// SPDX-License-Identifier: MIT
//
// Metadata of a point file from its header, printed by `stipple info`.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    STP_SCAN_FIELDS = 96,    ///< maximum number of listed fields
    STP_SCAN_NAME = 64,      ///< bytes of a name, with the zero
    STP_SCAN_COMPRESSOR = 48 ///< bytes, with the zero
};

typedef struct stp_scan_field {
    char name[STP_SCAN_NAME]; ///< Stipple's name if it is kept, else that of the format
    const char* type;         ///< "u8", "i16", "f64", "bits", "bytes", ...
    uint32_t count;           ///< values of a point
    bool kept;                ///< the importer reads it
    bool extra;               ///< LAS: it is one of the extra bytes
} stp_scan_field;

typedef struct stp_scan_info {
    const char* format; ///< the importer's name; NULL: it has no description
    bool alone;         ///< no point was read: the header has everything that `info` prints
    char version[STP_SCAN_NAME];
    uint64_t point_count;
    uint64_t scan_count;   ///< E57: number of scans; else 1
    int point_format;      ///< LAS: 0 to 10; other formats: -1
    uint32_t record_bytes; ///< size of an uncompressed point; 0: points have no fixed size
    bool has_box, has_steps;
    double low[3], high[3];     ///< in the file's own coordinates
    double scale[3], offset[3]; ///< position = integer coordinate * scale + offset
    double unit_metres;         ///< unit of heights and positions, if specified; 0: unknown
    bool compressed;
    char compressor[STP_SCAN_COMPRESSOR];
    uint64_t chunk_count;
    uint64_t chunk_points; ///< points of the largest chunk
    bool copc;
    uint32_t copc_levels;
    uint64_t copc_nodes; ///< nodes with points
    stp_scan_field fields[STP_SCAN_FIELDS];
    uint32_t field_count;
    uint32_t unnamed; ///< fields that are left out of the list
} stp_scan_info;

/// The next field to fill, or NULL if there is no room (it is still counted).
stp_scan_field* stp_scan_add_field(stp_scan_info* info, const char* name, size_t name_size,
                                   const char* type, bool kept);

/// Name and code of a coordinate system.
typedef struct stp_system_identity {
    char name[128]; ///< "" if the text has none
    uint32_t epsg;  ///< 0: the text has no code
} stp_system_identity;

/// From WKT 1 or 2, or "EPSG:N"; `text` may be NULL.
stp_system_identity stp_system_identify(const char* text);
