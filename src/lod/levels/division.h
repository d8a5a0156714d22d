// SPDX-License-Identifier: MIT
// Divides triangles into clusters, and clusters into groups.
#pragma once

#include "base/core/context.h"

/// Items, which are sets of triangles, divided into patches of neighbours. The arrays are owned.
typedef struct stp_division {
    float* centers;    ///< 3 per item; filled by the caller
    uint32_t* item_of; ///< per triangle; filled by the caller
    uint32_t* members; ///< items, patch by patch
    uint32_t* ends;    ///< of each patch in `members`
    uint32_t patch_count;
} stp_division;

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Destroy in either case
STP_MUST_USE stp_result stp_division_create(stp_context* context, uint32_t triangles,
                                            uint32_t items, stp_division* division);
void stp_division_destroy(stp_context* context, stp_division* division);

/// Divides the items into patches of at most `maximum`. `indices`: of all their triangles
STP_MUST_USE stp_result stp_divide(stp_context* context, const uint32_t* indices,
                                   uint32_t triangles, uint32_t vertex_count, uint32_t items,
                                   uint32_t maximum, stp_division* division);

/// Creates a division of single triangles. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged).
/// Destroy in either case
STP_MUST_USE stp_result stp_divide_triangles(stp_context* context, const float* positions,
                                             uint32_t vertex_count, const uint32_t* indices,
                                             uint32_t triangles, uint32_t maximum,
                                             stp_division* division);
