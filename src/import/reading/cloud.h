// SPDX-License-Identifier: MIT
//
// A point cloud under construction: as many cells as a file may have points; a reader fills each or
// leaves it empty. Large clouds use the scene's spill file from the start.
#pragma once

#include "import/reading/point_columns.h"

#include <assert.h>
#include <math.h>

typedef struct stp_cloud {
    stp_import* import;
    stp_point_set set; ///< one point per cell; a NaN position means empty
    double origin[3];  ///< added to positions
} stp_cloud;

/// For formats without axis and unit: up is z. If the user gave no unit either, a readable file
/// triggers a warning.
void stp_cloud_set_axes(stp_import* import);

/// Allocates `count` uninitialized cells with the columns of `desc` (its count is ignored). Destroy
/// the cloud in any case. @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_cloud_create(stp_cloud* cloud, stp_import* import, uint64_t count,
                                         const stp_point_columns_desc* desc);
void stp_cloud_destroy(stp_cloud* cloud);

/// Chooses the origin by stp_import_choose_origin. Call it before filling cells.
void stp_cloud_set_origin(stp_cloud* cloud, const double place[3]);

static inline void stp_cloud_leave_empty(const stp_cloud* cloud, size_t cell)
{
    assert(cell < cloud->set.point_count);
    float* p = cloud->set.positions + 3 * cell;
    p[0] = p[1] = p[2] = NAN;
}

static inline bool stp_cloud_is_empty(const stp_cloud* cloud, size_t cell)
{
    assert(cell < cloud->set.point_count);
    return isnan(cloud->set.positions[3 * cell]);
}

/// Sets the position of a cell. @return false if it is not finite: the cell is empty
static inline bool stp_cloud_place(const stp_cloud* cloud, size_t cell, const double place[3])
{
    assert(cell < cloud->set.point_count);
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

/// Removes the empty cells and adds the points to the scene: to a new object `name` below the
/// file's root, or to the root itself if `name` is NULL, placed by `pose` (double, from the cloud's
/// original coordinates). A cloud without points adds an object without parts. @return STP_OK,
/// STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cloud_finish(stp_cloud* cloud, const char* name,
                                         const stp_affine* pose);
