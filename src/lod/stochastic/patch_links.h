// SPDX-License-Identifier: MIT
// Which patches are neighbours, and what a step from one to the other tells about their sides.
#pragma once

#include "lod/stochastic/patches.h"

typedef struct stp_patch_link {
    uint32_t to;
    float weight;    ///< small where the sign is certain, and along a surface
    float agreement; ///< positive: the normals as they were given are on the same side
} stp_patch_link;

/// What a step between two patches tells: positive, their normals are on the same side.
float stp_patch_agreement(const stp_patch* a, const stp_patch* b);

typedef struct stp_patch_links {
    uint32_t* begins; ///< of each patch's links, one more than patches
    stp_patch_link* all;
    size_t count;
} stp_patch_links;

/// Links each patch with those near it, and those that it is near to, each pair once at both ends.
/// Between two patches the one's normal is mirrored in the plane between both, as if the surface
/// were bent evenly (König, Gumhold 2009); its product with the other is the agreement, more where
/// the weight is small.
/// @param near 1 to STP_LEAF_NEIGHBOURS_MOST
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_patch_links_destroy, also after a
/// failure
STP_MUST_USE stp_result stp_patch_links_make(stp_context* context, const stp_patches* patches,
                                             uint32_t near, stp_patch_links* links);
void stp_patch_links_destroy(stp_context* context, stp_patch_links* links);
