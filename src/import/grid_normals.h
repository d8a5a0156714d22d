// SPDX-License-Identifier: MIT
//
// Normals of a scan that was taken in a grid of columns and rows, from the neighbours of each cell.
#pragma once

#include "import/cloud.h"

typedef struct stp_scan_grid {
    uint32_t columns, rows;
    const uint32_t*
        cells; ///< column by column: the point of each cell, or STP_NONE; NULL: point r of column c is
               ///< c * rows + r
    stp_vec3 scanner; ///< where it stood, relative to the cloud's origin
} stp_scan_grid;

/// Fills the normals of the cloud (a column that it has). A normal is the cross product of the
/// differences to the neighbours in the column and in the row, towards the scanner; across a jump
/// in depth only the nearer neighbour counts. Points without such neighbours, and those of no cell,
/// face the scanner.
void stp_grid_normals(stp_cloud* cloud, const stp_scan_grid* grid);
