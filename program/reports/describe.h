// SPDX-License-Identifier: MIT
//
// Figures about the content of a scene: of a .stip file, or of an imported model that was not
// built.
#pragma once

#include "store/file/sides.h"
#include "store/writer/writer.h"

#include <jansson.h>

typedef struct scene_figures {
    stp_store_summary summary;
    stp_context* context; ///< owns the summary's memory; NULL: the store owns it
    /// Borrowed; views, sources, unit, up axis, methods and attributes are used
    const stp_store_directory* directory;
    uint64_t file_bytes;
    uint64_t whole_bytes; ///< complete size of a .stip; more than file_bytes if it is truncated
    uint32_t format_version, format_minor; ///< 0: not a .stip
    stp_store_level_figures levels;        ///< levels of triangles
    bool has_level_figures;                ///< false: an early file of version 1.3, without them
    stp_store_side_figures sides;          ///< what is drawn from the front only
    bool by_elevation;     ///< of a .stip: drawn by elevation if no colour is asked for
    double position_error; ///< maximum error of a .stip's points, scene units; 0: unknown or none
} scene_figures;

/// Figures of an open store: its summary, or computed from its tables if it has none. No bulk data
/// is read.
STP_MUST_USE stp_result describe_store(stp_context* context, stp_store* store,
                                       scene_figures* figures);
/// Figures of a scene that a writer would receive.
STP_MUST_USE stp_result describe_content(stp_context* context, const stp_store_content* content,
                                         scene_figures* figures);
void describe_destroy(scene_figures* figures);

/// JSON as printed by `info --json`; NULL if memory runs out.
json_t* describe_json(const scene_figures* figures);
/// Prints text as `info` does, on stdout.
void describe_print(const char* path, const scene_figures* figures);

/// The table of parts, and their sum: the layout of the paper's Table 1, on stdout.
void describe_print_table(const stp_store_summary* summary);
/// Formats a count for people: 12,345 or 2.35 G.
const char* describe_count(uint64_t count, char out[32]);
/// 554 MB, in powers of 1000.
const char* describe_bytes(uint64_t bytes, char out[32]);
/// Converts a text from a file, which may hold any bytes, to JSON (UTF-8); null if it is NULL.
/// Returns NULL if memory runs out.
json_t* describe_json_text(const char* text);
/// Prints a text from a file, without bytes that could control a terminal.
void describe_text(const char* text);

/// Name of a unit of length, such as "mm"; NULL if no unit has that length.
const char* describe_unit(double metres);
