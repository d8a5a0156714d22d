// SPDX-License-Identifier: MIT
//
// Rasterises triangles into the visibility buffer. Watertight: a pixel centre on a shared edge
// belongs to exactly one triangle (top-left rule on coordinates snapped to a sub-pixel grid).
// Triangles are two-sided, unless the mesh says otherwise.
#pragma once

#include "base/core/arena.h"
#include "raster/layer.h"

/// Fragment test for alpha masks. The barycentric weights are perspective-correct. Called only for
/// fragments that would be visible; `x` and `y` are column and row.
typedef bool (*stp_raster_keep)(const void* user, uint32_t triangle, float weight1, float weight2,
                                uint32_t x, uint32_t y);

typedef struct stp_raster_mesh {
    const float* positions; ///< 3 per vertex
    uint32_t vertex_count;
    const uint32_t* indices; ///< 3 per triangle
    uint32_t triangle_count;
    /// NULL, or one per triangle, which gets the id first_id + numbers[t]. Not together with
    /// `keep`.
    const uint32_t* numbers;
    /// Subtracted from positions before the matrix, for precision far from the origin.
    float offset[3];
    stp_raster_keep keep; ///< NULL: keep every fragment
    const void* keep_user;
    uint64_t* fragments; ///< NULL, or a counter of the fragments inside triangles
    /// NULL, or limits that fragments must lie between; requires `keep`.
    const stp_raster_layer* layer;
    /// 0: both sides are drawn. Above 0, below 0: only triangles whose corners turn clockwise or
    /// counter-clockwise in the picture.
    int32_t facing;
    /// 0, or pixels from the target's to those of a second picture, of what is seen from behind:
    /// the least nearness of each pixel wins, then the smaller id. Not together with `keep`.
    size_t behind;
} stp_raster_mesh;

/// Draws triangles; triangle t gets the id first_id + t. Clips to the near plane and to rows
/// [row_begin, row_end) of the target. `scratch` is rewound before return.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_raster_triangles(const stp_raster_target* target, uint32_t row_begin,
                                             uint32_t row_end, const stp_raster_matrix* matrix,
                                             float nearness_limit, const stp_raster_mesh* mesh,
                                             uint32_t first_id, stp_arena* scratch);

/// Draws into a buffer that holds only the picture's rows [first_row, first_row + band->height).
/// The pixels are those of the whole picture.
STP_MUST_USE stp_result stp_raster_triangles_in_band(
    const stp_raster_target* band, uint32_t first_row, const stp_raster_matrix* matrix,
    float nearness_limit, const stp_raster_mesh* mesh, uint32_t first_id, stp_arena* scratch);
