// SPDX-License-Identifier: MIT
//
// Normals of a scan taken in a grid of columns and rows, computed from the neighbours of each cell.
#pragma once

#include "import/reading/cloud.h"

typedef struct stp_scan_grid {
    uint32_t columns, rows;
    /// Column by column: the point of each cell, or STP_NONE. NULL: point r of column c is
    /// c * rows + r.
    const uint32_t* cells;
    stp_vec3 scanner; ///< position of the scanner, relative to the cloud's origin
} stp_scan_grid;

/// Fills the cloud's normal column, which must exist. A normal is the cross product of the
/// differences to the neighbours in the column and in the row, pointing to the scanner; at a depth
/// jump only the nearer neighbour counts. Points without such neighbours, or without a cell, get
/// the direction to the scanner.
void stp_grid_normals(stp_cloud* cloud, const stp_scan_grid* grid);
