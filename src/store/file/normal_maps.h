// SPDX-License-Identifier: MIT
//
// Normal maps of materials: a section of its own. Early readers skip it, and light triangles by
// their own normals.
#pragma once

#include "store/file/store.h"

/// One for each material that has a normal map, in the order of materials.
typedef struct stp_store_normal_map {
    uint32_t material;
    float scale; ///< see stp_store_material
    stp_store_texture_use use;
} stp_store_normal_map;

/// Checks that the records name materials in ascending order and textures, and gives the materials,
/// which must be read, their maps. Textures and scales are checked with the materials.
STP_MUST_USE stp_result stp_store_link_normal_maps(const stp_store* store);

/// Number of records that a file of this directory has; 0: it lacks the section.
uint32_t stp_store_count_normal_maps(const stp_store_directory* directory);
/// The records of a directory; the caller frees them (stp_free). @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_list_normal_maps(stp_context* context,
                                                   const stp_store_directory* directory,
                                                   stp_store_normal_map** records);
