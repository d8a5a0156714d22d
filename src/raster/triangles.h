// SPDX-License-Identifier: MIT
//
// Triangles into the visibility buffer. Watertight: a pixel centre on a shared edge belongs to
// exactly one triangle (top-left rule on coordinates snapped to a sub-pixel grid). Both windings
// are drawn.
#pragma once

#include "base/arena.h"
#include "raster/layer.h"

/// Whether a fragment is there, for alpha masks: barycentric weights are perspective-correct. Asked
/// only where the fragment would be seen; `x` and `y` are its column and row.
typedef bool (*stp_raster_keep)(const void* user, uint32_t triangle, float weight1, float weight2,
                                uint32_t x, uint32_t y);

typedef struct stp_raster_mesh {
    const float* positions; ///< 3 a vertex
    uint32_t vertex_count;
    const uint32_t* indices; ///< 3 a triangle
    uint32_t triangle_count;
    /// NULL, or one a triangle, which gets the id first_id + numbers[t]; without `keep`.
    const uint32_t* numbers;
    float offset[3]; ///< subtracted from each position before the matrix is applied: a mesh whose
                     ///< numbers are large and close together keeps its precision
    stp_raster_keep keep; ///< NULL: every fragment is there
    const void* keep_user;
    uint64_t* fragments; ///< NULL, or a count to which those that lie within triangles are added
    const stp_raster_layer* layer; ///< NULL, or what fragments must lie between; only with `keep`
} stp_raster_mesh;

/// Draws triangles; triangle t gets the id first_id + t. Clipped to the near plane and to rows
/// [row_begin, row_end) of the target. `scratch` is rewound before return.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (not logged)
STP_MUST_USE stp_result stp_raster_triangles(const stp_raster_target* target, uint32_t row_begin,
                                             uint32_t row_end, const stp_raster_matrix* matrix,
                                             float nearness_limit, const stp_raster_mesh* mesh,
                                             uint32_t first_id, stp_arena* scratch);

/// The same into a buffer that holds the picture's rows [first_row, first_row + band->height) only:
/// the pixels are those that the whole picture would have there.
STP_MUST_USE stp_result stp_raster_triangles_in_band(
    const stp_raster_target* band, uint32_t first_row, const stp_raster_matrix* matrix,
    float nearness_limit, const stp_raster_mesh* mesh, uint32_t first_id, stp_arena* scratch);

/// Where the ray through a point of the screen (a pixel's centre: column + 0.5, row + 0.5) meets a
/// triangle: perspective-correct weights of corners 1 and 2 (corner 0 has the rest), clamped to the
/// triangle. For shading a pixel after the fact.
void stp_raster_weights(const stp_raster_matrix* matrix, const float* a, const float* b,
                        const float* c, float pixel_x, float pixel_y, float* weight1,
                        float* weight2);
