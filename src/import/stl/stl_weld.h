// SPDX-License-Identifier: MIT
//
// Merges corners at the same position, with the same colour, to one vertex. A file of n triangles has about n / 2
// vertices, so the table is compact: four bytes per slot; positions of a binary file are read from
// it again instead of being stored.
#pragma once

#include "base/core/context.h"
#include "import/stl/stl_colors.h"

#include <stipple/types.h>

/// All zero with a context is an empty mesh.
typedef struct stp_weld {
    stp_context* context;
    const unsigned char* facets; ///< binary file: not owned; NULL: places are in `positions`
    stp_stl_coding coding;       ///< of its colours
    uint32_t* slots;   ///< 0: free; else 1 + the first corner at a place, or 1 + its vertex
    size_t slot_count; ///< a power of two, or 0
    float* positions;  ///< 3 per vertex; binary file: made by stp_weld_finish
    uint16_t* colors;  ///< bits of each vertex (stl_colors.h), made by stp_weld_finish; NULL: none
    uint32_t* indices;
    size_t vertex_count, vertex_capacity; ///< capacity in vertices
    size_t index_count, index_capacity;
} stp_weld;

/// The position of a corner of a binary file; -0 becomes 0.
stp_vec3 stp_stl_corner(const unsigned char* facets, size_t corner);

/// Starts a binary file with so many facets, fewer than 2^32 / 3. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_weld_begin(stp_weld* weld, const unsigned char* facets, size_t count,
                                       stp_stl_coding coding);
/// Adds the next corner; for a binary file that of stp_stl_corner. At most 2^32 - 2 are added.
STP_MUST_USE stp_result stp_weld_add(stp_weld* weld, stp_vec3 place);
/// Frees the table and completes the positions.
STP_MUST_USE stp_result stp_weld_finish(stp_weld* weld);
/// Frees everything and leaves an empty mesh. Set arrays that were taken over to NULL before.
void stp_weld_clear(stp_weld* weld);
