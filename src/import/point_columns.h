// SPDX-License-Identifier: MIT
//
// The columns of a point set while an importer fills them: in memory, or in the scene's spill where
// they are large beside what the scene keeps in memory. Scans are larger than memory: nothing of
// them is held twice.
#pragma once

#include "import/import.h"

/// Which columns to make besides the positions.
typedef struct stp_point_columns_desc {
    uint32_t point_count;
    bool normals, colors;
    uint32_t attributes; ///< bit i: attribute i (scene/attributes.h)
} stp_point_columns_desc;

/// Makes the columns of `set`, uninitialised; `set->spilled` says where they lie. Afterwards the
/// importer fills them, may lower set->point_count, and calls stp_point_columns_add or
/// stp_point_columns_free.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged; then `set` has no columns)
STP_MUST_USE stp_result stp_point_columns_create(stp_import* import,
                                                 const stp_point_columns_desc* desc,
                                                 stp_point_set* set);

/// Frees the columns of a set that is not added, and empties it. Nothing happens to an empty one.
void stp_point_columns_free(stp_import* import, stp_point_set* set);

/// Gives the set to the scene, as a part of the object added last, and empties `set`, also on
/// failure.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_point_columns_add(stp_import* import, stp_point_set* set);

/// Lets the system drop from memory what was read of the file and what was written to the scene's
/// spill. Importers call it after every few MB of a set that is spilled. Any thread.
void stp_point_columns_release(stp_import* import, const stp_point_set* set);

/// Whether points of so many bytes go to the scene's spill at once.
bool stp_points_go_to_spill(const stp_scene* scene, uint64_t bytes);

/// Moves the object of the file so that its points, which are relative to `origin` (in the file's
/// axes), are where the file has them. Once, after stp_import_set_axes.
void stp_import_set_origin(stp_import* import, const double origin[3]);
