// SPDX-License-Identifier: MIT
// The tree of states, and the search for an object in the graph.
#pragma once

#include "select/visibility.h"

/// A node at a place with mixed visibility. Holds the state of each edge and part: a value of
/// stp_show, or STP_SHOW_MIXED plus the index of another mixed state.
typedef struct stp_visibility_mixed {
    uint32_t* slots; ///< NULL: free
    uint32_t count;
    uint32_t next_free; ///< free states: 1 + index of the next one; 0: none
} stp_visibility_mixed;

struct stp_visibility {
    stp_context* context;
    const stp_store* store;
    const stp_store_directory* directory;
    stp_visibility_mixed* mixed;
    size_t mixed_count, mixed_capacity;
    uint32_t first_free; ///< 1 + index of a free state; 0: none
    uint32_t root;       ///< state of the whole scene
    uint64_t version;
    uint8_t* marks;     ///< per node, during a search; NULL before the first search
    uint8_t* has_parts; ///< per mesh, then per point set: whether the object contains it
};

/// Creates a mixed state for a node with a uniform state. @return STP_OK or STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_visibility_split(stp_visibility* visibility, uint32_t node,
                                             uint32_t state, uint32_t* split);
/// Frees a mixed state and all mixed states below it. Does nothing for a uniform state.
void stp_visibility_merge(stp_visibility* visibility, uint32_t state);
