// SPDX-License-Identifier: MIT
// Culling of groups of neighbouring splats (Dachsbacher et al. 2003, 3.10): those beside the picture, and those that face
// away wholly. Both backends ask here.
#pragma once

#include "raster/splats.h"

/// What of a view decides about groups. Rows are those of the matrix after the position grid.
typedef struct stp_raster_groups {
    float x[4], y[4], w[4];
    float width, height;
    float per_code; ///< a radius of one step, in numbers of the grid
    float eye[3];   ///< in numbers of the grid; in parallel projection the gaze, of unit length
    bool parallel;
    bool one_sided; ///< groups that face away are left out too
} stp_raster_groups;

/// The picture as groups are held against it.
typedef struct stp_raster_frame {
    uint32_t width, height;
    float margin; ///< pixels around it that count as inside
    bool one_sided;
} stp_raster_frame;

/// Of `splats`, which has positions on a grid, the grid and the radius are looked at.
stp_raster_groups stp_raster_groups_make(const stp_raster_camera* camera,
                                         const stp_raster_splats* splats,
                                         const stp_raster_frame* frame);

/// Whether nothing of a group can be seen.
bool stp_raster_drops_group(const stp_raster_groups* groups, const stp_splat_group* group);
