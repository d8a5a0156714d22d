// SPDX-License-Identifier: MIT
//
// Where things of a list lie on the screen: what all backends take from view and list in the same way.
#pragma once

#include "base/math.h"
#include "draw/draw.h"
#include "raster/splats.h"
#include "select/view_frame.h"
#include "store/store.h"

/// What all items of a picture have in common.
typedef struct stp_placement {
    stp_view_frame frame;
    double nearness_scale, nearness_offset; ///< nearness = offset + scale / depth, or scale * depth
    double mesh_depth; ///< how far triangles are put behind their place, in sides of a pixel there
    double shift_x, shift_y; ///< of the sample, pixels
} stp_placement;

/// Where one item lies.
typedef struct stp_placed_item {
    stp_raster_camera camera; ///< of positions minus the item's offset
    float near_factor,
        near_shift;            ///< true nearness = near_factor * that of the buffer + near_shift
    float normal_matrix[3][3]; ///< item to scene, not of unit scale
    float scale;               ///< scene units per item unit
} stp_placed_item;

/// How far triangles of a list are put behind their place, in sides of a pixel there.
double stp_placement_mesh_depth(const stp_draw_list* list);
/// The nearness of depths: `frame` and `mesh_depth` must be there.
void stp_placement_choose_nearness(stp_placement* placement, const stp_store_directory* directory);
/// Chooses the nearness and how triangles stand to splats; `frame` must be there. No shift.
void stp_placement_make(stp_placement* placement, const stp_store_directory* directory,
                        const stp_draw_list* list);
void stp_placement_place(const stp_placement* placement, const stp_draw_item* draw,
                         const float offset[3], stp_placed_item* item);

/// The part of splats' fragments that ghosts have, of which triangles have `share`.
float stp_placement_ghost_part(float share);

/// Item space (minus `offset`) to a view's right, down and depth: the eye is taken off before anything is rounded.
void stp_placement_view_rows(const stp_view_frame* frame, const stp_affine* transform,
                             const float offset[3], double rows[3][4]);

/// The part of a pixel that sample `sample` of side x side lies beside its middle.
static inline void stp_placement_shift(stp_placement* placement, uint32_t side, uint32_t sample)
{
    placement->shift_x = 0.5 - ((double)(sample % side) + 0.5) / (double)side;
    placement->shift_y = 0.5 - ((double)(sample / side) + 0.5) / (double)side;
}

/// Of what is drawn and where it is placed, and of nothing that changes from frame to frame: the same pixels of it are
/// left out in one pass and in two, and while other things come and go.
uint32_t stp_placement_seed(const stp_draw_item* draw);

/// Which of a set's octaves colour a prefix, and how much each.
typedef struct stp_octave_choice {
    uint32_t octave;    ///< that colours the prefix
    uint32_t low_count; ///< surfels of the octave before, which has colours of them too
    float blend;        ///< share of `octave` there
} stp_octave_choice;

stp_octave_choice stp_placement_choose_octave(const stp_splats* surfels, uint32_t prefix);
