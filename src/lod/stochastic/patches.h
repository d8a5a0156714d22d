// SPDX-License-Identifier: MIT
// Patches: what is turned as one when the outside of a cloud is looked for. A flat leaf is one
// patch. Any other leaf holds few points, and is divided into patches of neighbours that face the
// same way or the opposite one: both sides of a thin sheet, or the two of an edge, are apart.
#pragma once

#include "lod/stochastic/facts.h"

enum { STP_PATCHES_MOST = 24 }; ///< of a leaf

typedef struct stp_patch {
    stp_vec3 place;  ///< mean of its points, on the grid
    stp_vec3 normal; ///< of unit length, on either side
    float doubt;     ///< how little the normal can be relied on, 0 to about 1
    uint32_t leaf, count;
} stp_patch;

typedef struct stp_patches {
    stp_patch* all;
    uint32_t count;
    uint32_t* begins; ///< of each leaf's patches, leaf_count + 1
    uint8_t*
        of_points; ///< by place in the octree's order: the patch, from that of the leaf's first
} stp_patches;

/// On all threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_patches_destroy,
/// also after a failure
STP_MUST_USE stp_result stp_patches_make(stp_context* context, const stp_leaf_octree* octree,
                                         const stp_leaf_points* points, const stp_leaf_facts* facts,
                                         stp_patches* patches);
void stp_patches_destroy(stp_context* context, stp_patches* patches);
