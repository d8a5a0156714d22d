// SPDX-License-Identifier: MIT
//
// Which materials and shadings are drawn from the front only: single-sided ones of glTF
// (STP_SHADING_FRONT_ONLY in their flags).
#pragma once

#include "store/file/store.h"

/// One for each material, then one for each shading.
typedef struct stp_store_sides {
    uint32_t flags;     ///< STP_SIDES_*
    uint32_t inverted;  ///< of a material: closed meshes whose fronts face inwards
    uint64_t triangles; ///< of a material: stored triangles that have it, without levels
} stp_store_sides;

enum { STP_SIDES_FRONT_ONLY = 1 };

/// What is drawn from the front only.
typedef struct stp_store_side_figures {
    uint64_t materials, triangles; ///< stored; materials that triangles have
    uint64_t inverted;             ///< closed meshes whose fronts face inwards
} stp_store_side_figures;

/// Checks the decoded records and their number. Materials and shadings need not be read.
STP_MUST_USE stp_result stp_store_validate_sides(const stp_store* store);
/// Checks them and sets the flags of the materials and shadings, which must be read.
STP_MUST_USE stp_result stp_store_link_sides(stp_store* store);

/// Of an open store; all 0 if its file does not tell. Sums end at UINT64_MAX.
stp_store_side_figures stp_store_get_side_figures(const stp_store* store);

/// Whether a file of this directory has the section.
bool stp_store_tells_sides(const stp_store_directory* directory);
/// The records of a content; the caller frees them (stp_free). @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_sides_of_content(stp_context* context,
                                                   const stp_store_content* content,
                                                   stp_store_sides** records);
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_side_figures_of_content(stp_context* context,
                                                          const stp_store_content* content,
                                                          stp_store_side_figures* figures);
