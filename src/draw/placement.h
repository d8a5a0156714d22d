// SPDX-License-Identifier: MIT
//
// Placement of a list's items on the screen, shared by all backends.
#pragma once

#include "base/math/math.h"
#include "draw/draw.h"
#include "raster/splats.h"
#include "select/view_frame.h"
#include "store/file/store.h"

#include <assert.h>

/// Parameters common to all items of a picture.
typedef struct stp_placement {
    stp_view_frame frame;
    double nearness_scale, nearness_offset; ///< nearness = offset + scale / depth, or scale * depth
    double mesh_depth;       ///< depth offset of triangles, in pixel sides at their depth
    double shift_x, shift_y; ///< shift of the picture for the current sample, pixels
} stp_placement;

/// Placement of one item.
typedef struct stp_placed_item {
    stp_raster_camera camera; ///< for positions minus the item's offset
    float near_factor,
        near_shift;            ///< true nearness = near_factor * that of the buffer + near_shift
    float normal_matrix[3][3]; ///< item to scene, with scale
    float scale;               ///< scene units per item unit
} stp_placed_item;

/// Depth offset of a list's triangles, in pixel sides at their depth.
double stp_placement_mesh_depth(const stp_draw_list* list);
/// Sets the nearness function: `frame` and `mesh_depth` must be set.
void stp_placement_choose_nearness(stp_placement* placement, const stp_store_directory* directory);
/// Chooses the nearness function and the depth offset of triangles; `frame` must be set. No shift.
void stp_placement_make(stp_placement* placement, const stp_store_directory* directory,
                        const stp_draw_list* list);
void stp_placement_place(const stp_placement* placement, const stp_draw_item* draw,
                         const float offset[3], stp_placed_item* item);

/// Drawn share of a ghost's splat fragments, given the `share` of its triangle fragments.
float stp_placement_ghost_part(float share);

/// Maps item space (minus `offset`) to a view's right, down and depth; subtracts the eye before
/// rounding.
void stp_placement_view_rows(const stp_view_frame* frame, const stp_affine* transform,
                             const float offset[3], double rows[3][4]);

/// Sets the shift of the picture that moves sample `sample` of side x side to the pixel's centre.
static inline void stp_placement_shift(stp_placement* placement, uint32_t side, uint32_t sample)
{
    assert(side > 0 && sample < side * side);
    placement->shift_x = 0.5 - ((double)(sample % side) + 0.5) / (double)side;
    placement->shift_y = 0.5 - ((double)(sample / side) + 0.5) / (double)side;
}

/// Hash seed of an item: depends only on the item and its place. So the same pixels are left out in
/// one pass and in two, and while other items come and go.
uint32_t stp_placement_seed(const stp_draw_item* draw);

/// The octaves of a set that colour a prefix, and their weights.
typedef struct stp_octave_choice {
    uint32_t octave;    ///< octave of the prefix
    uint32_t low_count; ///< splats before `octave`, for which the previous octave has colours too
    float blend;        ///< weight of the colours of `octave` for these splats, 0 to 1
} stp_octave_choice;

stp_octave_choice stp_placement_choose_octave(const stp_splats* splats, uint32_t prefix);
