// SPDX-License-Identifier: MIT
//
// A cloud of points in the making: as many cells as a file may have points, each of which a reader
// fills or leaves empty. Large clouds lie in the scene's spill from the start.
#pragma once

#include "import/point_columns.h"

#include <math.h>

typedef struct stp_cloud {
    stp_import* import;
    stp_point_set set; ///< a point a cell; a position that is not-a-number: empty
    double origin[3];  ///< what positions are relative to
} stp_cloud;

/// For formats that say neither axis nor unit: up is z. Where no unit is given either, a file that
/// can be read brings a warning.
void stp_cloud_set_axes(stp_import* import);

/// Makes room for `count` cells, uninitialised, with the columns of `desc` (its count is not read).
/// Destroy it in any case. @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_cloud_create(stp_cloud* cloud, stp_import* import, uint64_t count,
                                         const stp_point_columns_desc* desc);
void stp_cloud_destroy(stp_cloud* cloud);

/// Far from zero, as in national grids, floats would lose digits: a round place near `place`
/// becomes the origin. Not finite coordinates count as zero. Before any cell is filled.
void stp_cloud_set_origin(stp_cloud* cloud, const double place[3]);

static inline void stp_cloud_leave_empty(const stp_cloud* cloud, size_t cell)
{
    float* p = cloud->set.positions + 3 * cell;
    p[0] = p[1] = p[2] = NAN;
}

static inline bool stp_cloud_is_empty(const stp_cloud* cloud, size_t cell)
{
    return isnan(cloud->set.positions[3 * cell]);
}

/// Fills the position of a cell. @return false where it is not finite: the cell is empty
static inline bool stp_cloud_place(const stp_cloud* cloud, size_t cell, const double place[3])
{
    float* p = cloud->set.positions + 3 * cell;
    for (int i = 0; i < 3; ++i) {
        p[i] = (float)(place[i] - cloud->origin[i]);
    }
    if (stp_is_finite((stp_vec3){p[0], p[1], p[2]})) {
        return true;
    }
    stp_cloud_leave_empty(cloud, cell);
    return false;
}

/// Drops the empty cells and hands the points to the scene: to an object `name` of its own below
/// the file's root, or to the root itself where `name` is NULL, placed by `pose` (double, from the
/// cloud's own coordinates before the origin was taken off). A cloud without points adds an object
/// without parts.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cloud_finish(stp_cloud* cloud, const char* name,
                                         const stp_affine* pose);
