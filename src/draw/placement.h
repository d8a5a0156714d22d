// SPDX-License-Identifier: MIT
//
// Placement of a list's items on the screen, shared by all backends: cameras, depth offsets,
// fixed-size points, and frustum culling.
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
/// Offset of a mesh item: the middle of its box. For a level, the middle of its node's: then corners
/// that levels of a node share are rounded alike, and levels meet without cracks.
void stp_mesh_offset(const stp_store* store, const stp_store_directory* directory,
                     const stp_draw_item* item, float offset[3]);
void stp_placement_place(const stp_placement* placement, const stp_draw_item* draw,
                         const float offset[3], stp_placed_item* item);

/// Drawn share of a ghost's splat fragments, given the `share` of its triangle fragments.
float stp_placement_ghost_part(float share);

/// Maps item space (minus `offset`) to a view's right, down and depth; subtracts the eye before
/// rounding.
void stp_placement_view_rows(const stp_view_frame* frame, const stp_affine* transform,
                             const float offset[3], double rows[3][4]);

/// Shift of the picture, in pixels, that moves sample `sample` of side x side to the pixel's centre.
static inline void stp_placement_shift(uint32_t side, uint32_t sample, double* x, double* y)
{
    assert(side > 0 && sample < side * side);
    *x = 0.5 - ((double)(sample % side) + 0.5) / (double)side;
    *y = 0.5 - ((double)(sample / side) + 0.5) / (double)side;
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

// Fixed-size points: which items have them, and their size. Such a point is a disk that faces the
// eye, drawn in full.

/// Depth of a point's rim behind its centre, in radii: a pixel of overlapping points shows the one
/// with the nearest centre.
#define STP_POINT_RIM_DEPTH 1.0f

/// Radius of an item's points: one of the two is 0.
typedef struct stp_point_radius {
    float units;  ///< in item space
    float pixels; ///< on the screen
} stp_point_radius;

static inline bool stp_point_size_is_fixed(const stp_draw_style* style, const stp_draw_item* item)
{
    return style->point_sizing != STP_POINTS_ADAPTIVE && item->of_points;
}

static inline stp_point_radius stp_point_radius_of(const stp_draw_style* style,
                                                   const stp_draw_item* item)
{
    assert(stp_point_size_is_fixed(style, item) && "other points have the radius of their item");
    float half = 0.5f * style->point_size;
    if (style->point_sizing == STP_POINTS_PIXELS) {
        // a disk that may fall between pixel centres covers the pixel of its centre
        return (stp_point_radius){.pixels = half < 0.7072f ? 0.2f : half};
    }
    double scale = stp_affine_scale(&item->transform);
    return (stp_point_radius){.units = scale > 0.0 ? (float)((double)half / scale) : 0.0f};
}

// Frustum culling of boxes in item space, and their nearest depth.

/// Frustum planes: a point p in item space, relative to the item's offset, with a.p + b < 0 is not
/// visible.
typedef struct stp_bounding {
    double a[5][3], b[5];
    double offset[3];
    float depth[4]; ///< the row of W
    float shift[3]; ///< the offset
} stp_bounding;

/// Makes the sides of a picture, one pixel outside it, and the near plane.
/// @param rows from item space, relative to `offset`, to the screen: x, y, nearness, W
stp_bounding stp_bounding_make(const float rows[4][4], float nearness_limit, const float offset[3],
                               uint32_t width, uint32_t height);
/// Whether the whole box lies behind one of the planes, with a margin for rounding.
bool stp_bounding_misses(const stp_bounding* bounding, stp_box box);
/// Minimum depth (W) of a box.
float stp_bounding_min_depth(const stp_bounding* bounding, stp_box box);
/// Maximum depth (W) of a box.
float stp_bounding_max_depth(const stp_bounding* bounding, stp_box box);

/// Which clusters of a level are drawn from a place: the same for all levels of a node, so that
/// their mixture has no cracks.
typedef struct stp_level_choice {
    const stp_store_level_cluster* clusters; ///< of the level
    const stp_store_level_group* groups;
    double depth[4];           ///< the row of W, in item space
    double steepness;          ///< change of W per unit
    double per_depth, minimum; ///< allowed error at depth 1, and anywhere
} stp_level_choice;

/// @param rows  as in stp_bounding_make
stp_level_choice stp_level_choice_make(const stp_store_directory* directory,
                                       const stp_draw_item* item, const float rows[4][4],
                                       const float offset[3]);
/// Whether the errors of a cluster's groups suit the depths of their spheres.
bool stp_level_choice_draws(const stp_level_choice* choice, uint32_t cluster);
