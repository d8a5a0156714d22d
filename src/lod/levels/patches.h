// SPDX-License-Identifier: MIT
// Divides items that touch each other into compact patches of bounded size, with short borders.
#pragma once

#include "base/core/context.h"

/// Which items touch: symmetric.
typedef struct stp_patch_links {
    uint32_t* first;      ///< places in `neighbours`, one per item and one more
    uint32_t* neighbours; ///< of each item, ascending
    uint32_t* weights;    ///< per neighbour: number of common edges
} stp_patch_links;

/// Links items, which are sets of triangles, that have a common edge.
/// @param item_of item of each triangle, below `item_count`
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Destroy the links in either case
STP_MUST_USE stp_result stp_patch_links_make(stp_context* context, const uint32_t* indices,
                                             uint32_t triangle_count, uint32_t vertex_count,
                                             const uint32_t* item_of, uint32_t item_count,
                                             stp_patch_links* links);
void stp_patch_links_destroy(stp_context* context, stp_patch_links* links);

/// Grows one patch after the other: an item that shares most of its border with the patch joins it
/// first, and of equal ones the nearest to its middle. A patch without neighbours left goes on with
/// the next item along a space-filling curve, so all but the last are full. Deterministic; one
/// thread.
/// @param centers 3 per item
/// @param maximum items of a patch, above 0
/// @param members receives all items, patch by patch
/// @param ends room for one number per item; receives the end of each patch in `members`
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_grow_patches(stp_context* context, const stp_patch_links* links,
                                         const float* centers, uint32_t count, uint32_t maximum,
                                         uint32_t* members, uint32_t* ends, uint32_t* patch_count);
