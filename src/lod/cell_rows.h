// SPDX-License-Identifier: MIT
//
// Points sorted by the cells of a grid, row by row along x. The three rows of three cells above,
// beside and below a cell are nine ranges of points, and each range moves forward as the cell does:
// a pass over all cells finds their neighbours without searching.
#pragma once

#include "base/core/context.h"

#include <assert.h>

enum {
    STP_CELL_LANES = 8, ///< columns may be read in vectors of this many points, past their end
    STP_CELL_ROWS = 9,  ///< rows around a cell, itself included
};

typedef struct stp_cell_rows {
    uint32_t count, cell_count;
    uint32_t* starts; ///< first point of each cell, and the end
    /// Number of each cell, ascending: by z, then y, then x; UINT64_MAX at the end
    uint64_t* numbers;
    uint64_t* items;       ///< per sorted point: number of its cell above its index
    unsigned index_bits;   ///< bits of an index in `items`
    unsigned axis_bits[3]; ///< bits of x, y, z in a cell's number
    float *x, *y, *z;      ///< positions in this order, in one block of memory
} stp_cell_rows;

/// Sorts points by cell, and by index within each cell.
/// @param positions 3 per point, finite
/// @param cell side of a cell, raised to at least 2^-100; doubled until cell numbers fit into 64 bits with the index
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_cell_rows_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_cell_rows_make(stp_context* context, const float* positions,
                                           uint32_t count, float cell, stp_cell_rows* rows);
void stp_cell_rows_destroy(stp_context* context, stp_cell_rows* rows);

/// Index of a sorted point among the given positions.
static inline uint32_t stp_cell_rows_index(const stp_cell_rows* rows, size_t at)
{
    assert(at < rows->count);
    return (uint32_t)(rows->items[at] & (((uint64_t)1 << rows->index_bits) - 1));
}

/// The 3 x 3 x 3 cells around a cell, as rows of up to three.
typedef struct stp_cell_window {
    const stp_cell_rows* rows;
    uint32_t begins[STP_CELL_ROWS], ends[STP_CELL_ROWS]; ///< cells of each row
} stp_cell_window;

/// Prepares to move from a cell on.
void stp_cell_window_start(const stp_cell_rows* rows, uint32_t cell, stp_cell_window* window);
/// Finds the cells around a cell at or after the previous one.
void stp_cell_window_move(stp_cell_window* window, uint32_t cell);

/// Offsets of cells that are at most some cells away from one, within the grid.
typedef struct stp_cell_reach {
    uint64_t number;                ///< number of the cell
    int64_t minimum[3], largest[3]; ///< offsets of x, y, z, in cells
    uint32_t next;                  ///< cells before this one are passed
} stp_cell_reach;

/// @param number number of the cell that contains a point
/// @param cells maximum distance on each axis, in cells
stp_cell_reach stp_cell_reach_around(const stp_cell_rows* rows, uint64_t number, uint32_t cells);
/// Finds the cells of a row, at offsets y and z, by searching from the previous row on: rows must
/// ascend by z, then y.
void stp_cell_reach_row(const stp_cell_rows* rows, stp_cell_reach* reach, int64_t y, int64_t z,
                        uint32_t* begin, uint32_t* end);
