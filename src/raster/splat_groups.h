// SPDX-License-Identifier: MIT
// Frustum and backface culling of groups of neighbouring splats (Dachsbacher et al. 2003, 3.10).
// Shared by both backends.
#pragma once

#include "raster/splats.h"

/// View parameters for group culling. Rows are those of the matrix after the position grid.
typedef struct stp_raster_groups {
    float x[4], y[4], w[4];
    float width, height;
    float per_code; ///< radius of one step, in grid coordinates
    float eye[3];   ///< in grid coordinates; in parallel projection the unit view direction
    bool parallel;
    bool one_sided; ///< cull groups that face away
} stp_raster_groups;

/// The picture against which groups are culled.
typedef struct stp_raster_frame {
    uint32_t width, height;
    float margin; ///< pixels around it that count as inside
    bool one_sided;
} stp_raster_frame;

/// The eye in grid coordinates; in parallel projection the unit view direction.
void stp_raster_find_eye(const stp_raster_camera* camera, const stp_raster_splats* splats,
                         float eye[3]);

/// Of `splats`, which has positions on a grid, only the grid and the radius are used.
stp_raster_groups stp_raster_groups_make(const stp_raster_camera* camera,
                                         const stp_raster_splats* splats,
                                         const stp_raster_frame* frame);

/// Whether the whole group is invisible.
bool stp_raster_drops_group(const stp_raster_groups* groups, const stp_splat_group* group);
