// SPDX-License-Identifier: MIT
//
// Corners at the same place become one vertex. A file of n triangles has about n / 2 vertices, so
// the table is kept small: four bytes a slot, and the places of a binary file are read in it again
// instead of being kept meanwhile.
#pragma once

#include "base/context.h"

#include <stipple/types.h>

#define STP_STL_FACET_SIZE ((size_t)50)

/// Zero with a context is an empty mesh.
typedef struct stp_weld {
    stp_context* context;
    const unsigned char* facets; ///< of a binary file; NULL: places are kept in `positions`
    uint32_t* slots;   ///< 0: free; else 1 + the first corner at a place, or 1 + its vertex
    size_t slot_count; ///< a power of two, or 0
    float* positions;  ///< of a binary file: once it is finished
    uint32_t* indices;
    size_t vertex_count, vertex_capacity; ///< capacity in vertices
    size_t index_count, index_capacity;
} stp_weld;

/// The place of a corner of a binary file; -0 is 0: the same place.
stp_vec3 stp_stl_corner(const unsigned char* facets, size_t corner);

/// Begins a binary file of so many facets, fewer than 2^32 / 3. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_weld_begin(stp_weld* weld, const unsigned char* facets, size_t count);
/// The next corner; of a binary file stp_stl_corner's. At most 2^32 - 2 are added.
STP_MUST_USE stp_result stp_weld_add(stp_weld* weld, stp_vec3 place);
/// Gives up the table and completes the positions.
STP_MUST_USE stp_result stp_weld_finish(stp_weld* weld);
/// Frees everything: an empty mesh again. Arrays that were taken over are set to NULL before.
void stp_weld_clear(stp_weld* weld);
