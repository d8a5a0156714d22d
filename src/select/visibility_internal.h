// SPDX-License-Identifier: MIT
// The tree of states, and how a thing is found in the graph.
#pragma once

#include "select/visibility.h"

/// A node at a place of which not everything is shown alike: the state of each edge and part, one of stp_show or
/// STP_SHOW_MIXED and the index of another of these.
typedef struct stp_visibility_mixed {
    uint32_t* slots; ///< NULL: free
    uint32_t count;
    uint32_t next_free; ///< and 1; 0: none
} stp_visibility_mixed;

struct stp_visibility {
    stp_context* context;
    const stp_store* store;
    const stp_store_directory* directory;
    stp_visibility_mixed* mixed;
    size_t mixed_count, mixed_capacity;
    uint32_t first_free; ///< and 1; 0: none
    uint32_t root;       ///< state of the whole scene
    uint64_t version;
    uint8_t* marks;     ///< of each node, while a thing is looked for; NULL before the first time
    uint8_t* has_parts; ///< of each mesh, then of each point set: whether the thing has it
};

/// Makes a mixed state of a node that has been of one state. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_visibility_split(stp_visibility* visibility, uint32_t node,
                                             uint32_t state, uint32_t* split);
/// Frees what a state has below it.
void stp_visibility_merge(stp_visibility* visibility, uint32_t state);
