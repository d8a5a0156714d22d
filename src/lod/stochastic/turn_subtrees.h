// SPDX-License-Identifier: MIT
// Turns parts of a tree of patches against the rest where more neighbours then agree.
#pragma once

#include "lod/stochastic/patch_links.h"

/// How patches were reached, one from another.
typedef struct stp_patch_tree {
    uint32_t* parents;  ///< of each patch; itself at a root
    uint32_t* depths;   ///< steps from the root
    uint32_t* sequence; ///< of all patches: a parent before those reached from it
    uint32_t count;
} stp_patch_tree;

/// Turns subtrees, those whose links to the rest disagree more than they agree, until none is left
/// or turning helps no more. Roots stay. The sides of a link's ends agree where its agreement is
/// positive and both or none of them are turned.
/// @param turned of each patch, whether its normal is
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_turn_subtrees(stp_context* context, const stp_patch_links* links,
                                          const stp_patch_tree* tree, bool* turned);
