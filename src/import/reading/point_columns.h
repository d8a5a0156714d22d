// SPDX-License-Identifier: MIT
//
// The columns of a point set while an importer fills them: in memory, or in the scene's spill file
// if they are large compared to its memory limit. Scans may be larger than memory, so nothing is
// stored twice.
#pragma once

#include "import/reading/import.h"

/// Columns to make besides the positions.
typedef struct stp_point_columns_desc {
    uint32_t point_count;
    bool normals, colors;
    uint32_t attributes; ///< bit i: attribute i (stipple/attributes.h)
} stp_point_columns_desc;

/// Allocates the columns of `set`, uninitialized; `set->spilled` tells where they are. Afterwards
/// the importer fills them, may lower set->point_count, and calls stp_point_columns_add or
/// stp_point_columns_free. @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged; then
/// `set` has no columns)
STP_MUST_USE stp_result stp_point_columns_create(stp_import* import,
                                                 const stp_point_columns_desc* desc,
                                                 stp_point_set* set);

/// Frees the columns of a set that is not added, and empties it. Does nothing for an empty one.
void stp_point_columns_free(stp_import* import, stp_point_set* set);

/// Adds the set to the scene, as a part of the last object, and empties `set`, even on failure.
/// Times that are not finite, or beyond STP_SCENE_TIME_LIMIT, become 0 and count as losses.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_point_columns_add(stp_import* import, stp_point_set* set);

/// Releases file content that was read and data written to the spill file from memory. Importers
/// call it after every few MB of a spilled set. Any thread.
void stp_point_columns_release(stp_import* import, const stp_point_set* set);

/// Whether this many bytes of points go directly to the scene's spill file.
bool stp_points_go_to_spill(const stp_scene* scene, uint64_t bytes);

/// A round position near `place` if that is far from zero, as in national grids, where floats would
/// lose digits; else zero. Coordinates that are not finite, or reach 1e15, count as zero.
void stp_import_choose_origin(const double place[3], double origin[3]);

/// Moves the file's object so that its points, which are relative to `origin` (in the file's axes),
/// are at their original positions. Call it once, after stp_import_set_axes.
void stp_import_set_origin(stp_import* import, const double origin[3]);
