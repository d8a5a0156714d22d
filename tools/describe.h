// SPDX-License-Identifier: MIT
//
// What a scene holds, in figures: of a .stip file, or of a model that was imported but not built.
#pragma once

#include "store/writer.h"

#include <jansson.h>

/// One top-level object: an input file, as a rule.
typedef struct part_figures {
    const char* name; ///< may be NULL
    uint64_t objects, instances, triangles, points;
} part_figures;

/// Counts; where things are instanced, `unique_...` counts each once. Sums stop at the largest number.
typedef struct scene_figures {
    uint64_t nodes, unique_nodes, objects, instances, triangles, unique_triangles, points,
        unique_points;
    uint64_t surfels, unique_surfels;
    uint64_t splat_bytes, triangle_bytes, point_bytes, texture_bytes;
    part_figures* parts;
    size_t part_count;
    uint64_t file_bytes;
    uint32_t format_version; ///< 0: not a .stip
    const stp_store_directory* directory;
} scene_figures;

/// Of an open store: no bulk data is read. @return false where memory runs out
bool describe_store(const stp_store* store, scene_figures* figures);
/// Of what a writer would be given.
bool describe_content(const stp_store_content* content, scene_figures* figures);
void describe_destroy(scene_figures* figures);

/// As `info --json` prints it; NULL where memory runs out.
json_t* describe_json(const scene_figures* figures);
/// As `info` prints it, on stdout.
void describe_print(const char* path, const scene_figures* figures);

/// The name of a unit of length, "mm"; NULL where there is none of that length.
const char* describe_unit(double metres);
