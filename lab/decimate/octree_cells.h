// SPDX-License-Identifier: MIT
// Points sorted into the cells of an octree, and chosen cells.
#pragma once

#include "lab/decimate/decimator.h"

enum { STP_OCTREE_LEVELS = 21 }; ///< number of levels below the root

/// Points that share a cell: those at [begin, end) of the octree's order.
typedef struct stp_octree_cell {
    uint32_t begin, end;
    uint32_t level; ///< 0: the root
    float size;     ///< diagonal of the box of its disks; 0 from stp_octree_cells_take_level
} stp_octree_cell;

typedef struct stp_octree_cells {
    stp_context* context;
    const stp_decimate_input* input;
    const stp_ellipse* disks; ///< one per point
    /// Codes of the points in order, ascending: 3 bits per level, the root's children first
    uint64_t* codes;
    uint32_t* order;        ///< points by their codes
    stp_octree_cell* cells; ///< chosen cells
    uint32_t count;         ///< number of chosen cells
} stp_octree_cells;

/// Sorts points along the octree's curve. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_octree_cells_make(stp_octree_cells* tree);
/// Chooses cells: starting at the root, replaces the largest one by its children, as long as there
/// are at most `target`.
STP_MUST_USE stp_result stp_octree_cells_open(stp_octree_cells* tree, uint32_t target);
/// Chooses all cells of the level whose number of cells is nearest to `target`; of two, the one
/// with fewer.
STP_MUST_USE stp_result stp_octree_cells_take_level(stp_octree_cells* tree, uint32_t target);
void stp_octree_cells_destroy(stp_octree_cells* tree);

// Assigns each point to the nearest chosen point.

/// Points of each chosen one, including itself: members from starts[i] to before starts[i + 1],
/// ascending.
typedef struct stp_decimate_cells {
    uint32_t* owners; ///< per point, the number of a chosen one
    uint32_t* starts;
    uint32_t* members;
} stp_decimate_cells;

/// Assigns each point to the nearest chosen one that does not face away from it; if there is none,
/// to the nearest one.
/// @param chosen points that are at least `radius` apart, unless they face apart
/// @param radius maximum distance of any point to the chosen ones
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); freed by stp_decimate_cells_destroy, also
///         after a failure
STP_MUST_USE stp_result stp_decimate_cells_make(stp_context* context,
                                                const stp_decimate_input* input,
                                                const uint32_t* chosen, uint32_t count,
                                                float radius, stp_decimate_cells* cells);
void stp_decimate_cells_destroy(stp_context* context, stp_decimate_cells* cells);
