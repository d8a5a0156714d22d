// SPDX-License-Identifier: MIT
// Values of scanned points: scales of intensities and colours, and normals from the grid of a scan.
#pragma once

#include "import/reading/cloud.h"

#include <assert.h>
#include <float.h>
#include <math.h>

// Files use their own units for the strength of an echo; the scene uses 0 to 65535.

/// The values that become 0 and 65535.
typedef struct stp_intensity_range {
    double low, high;
} stp_intensity_range;

/// Widens a range (empty: low above high) by a value of a file, unless that is not finite.
static inline void stp_range_add(double value, double* low, double* high)
{
    *low = value < *low && value >= -DBL_MAX ? value : *low;
    *high = value > *high && value <= DBL_MAX ? value : *high;
}

/// Chooses the range from the minimum and maximum of a file that does not specify it: up to 1, 255
/// or 65535, whichever fits; -2048 to 2047 if a value is negative; otherwise minimum to maximum.
/// Without values (low above high): up to 1.
static inline stp_intensity_range stp_intensity_find_range(double low, double high)
{
    if (low >= -2048.0 && low < 0.0 && high <= 2047.0) {
        return (stp_intensity_range){-2048.0, 2047.0};
    }
    if (low <= high && (low < 0.0 || high > 65535.0)) {
        double above = low + 1.0 > low ? low + 1.0 : low + fabs(low) * DBL_EPSILON;
        return (stp_intensity_range){low, high > low ? high : above};
    }
    return (stp_intensity_range){0.0, high <= 1.0 ? 1.0 : high <= 255.0 ? 255.0 : 65535.0};
}

/// The value of white, from the brightest colour of a file that does not specify it: 1 if colours
/// may be fractions and none is above 1; 255 or 65535 otherwise.
static inline double stp_color_white(double bright, bool may_be_fractions)
{
    return bright > 255.0 ? 65535.0 : bright <= 1.0 && may_be_fractions ? 1.0 : 255.0;
}

/// The factor for the difference from `low`.
static inline double stp_intensity_factor(stp_intensity_range range)
{
    return 65535.0 / (range.high - range.low);
}

/// Rounds to a whole number and clamps to `maximum`; NaN gives 0.
static inline double stp_quantize(double value, double maximum)
{
    assert(maximum > 0.0 && "callers cast the result to an unsigned type");
    value = value > 0.0 ? value + 0.5 : 0.0;
    return value < maximum ? value : maximum;
}

// Normals of a scan taken in a grid of columns and rows, computed from the neighbours of each cell.

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
