// SPDX-License-Identifier: MIT
// Number of splats that a view takes from a leaf, or from a cube of several leaves: by the paper's
// five cues (Bhakar, Luo, Mudur 2004, 2 and Table 1), by coverage, and for highlights.
#pragma once

#include "select/select_internal.h"
#include "store/file/store.h"

/// Table 1.
#define STP_CUE_BENT 2.0       ///< factor on samples of a region as bent as STP_LEAF_BENT
#define STP_CUE_FEATURE 4.0    ///< factor on samples at a silhouette or an edge
#define STP_CUE_OCCLUSION 0.01 ///< reduction by occluding points per pixel of a region

/// For STP_CUE_ERROR_BIT. Evenly spread points (lod/stochastic/leaf_passes.h) cover the surface
/// with disks of radius 1.05 times the side of each point's square. Takes as many points as make
/// that radius half a splat size.
#define STP_CUE_COVERING 4.41     ///< (2 x 1.05)^2 splats per square of the splat size
#define STP_CUE_ERROR_BENT 1.25   ///< factor on samples of a bent region
#define STP_CUE_ERROR_FEATURE 1.5 ///< factor at a silhouette, an edge or a highlight
#define STP_CUE_HIGHLIGHT 0.26    ///< sine of a highlight's angle around the mirror direction

#define STP_CUE_RADIUS 1.05 ///< radius of a splat, in sides of the square that it represents
#define STP_CUE_LONGEST 1.5 ///< limit on an ellipse's larger radius, in those of its disk

/// A set in a view.
typedef struct stp_cue_view {
    const stp_selection* s;
    const stp_select_entry* at;
    const stp_splats* set;
    const stp_store_leaves* leaves;
    const stp_box_visibility* sight; ///< for the whole set
    uint32_t cues;                   ///< STP_CUE_*_BIT
    double scale;                    ///< scale of lengths, to scene space
    stp_vec3d eye;   ///< grid position; in parallel projection the direction towards it
    stp_vec3d light; ///< towards the light, in set space
    bool flat_view;  ///< parallel projection
    bool polished;   ///< some materials may show highlights
} stp_cue_view;

/// @param sight of the node
stp_cue_view stp_cue_view_make(const stp_selection* s, const stp_select_entry* at,
                               const stp_splats* set, const stp_store_leaves* leaves,
                               const stp_box_visibility* sight);

/// Box of an octree cube, in scene space. Splats are larger: see stp_cue_overhang.
stp_boxd stp_cue_box(const stp_cue_view* view, const stp_leaf_node* node);

/// Whether any splat of a cube may be in view. Splats extend beyond the cube, and all its points may
/// lie on the face next to the picture.
bool stp_cue_is_in_view(const stp_cue_view* view, const stp_leaf_node* node,
                        stp_box_visibility* sight);

/// Upper limit on how far splats of a cube extend beyond its box, in scene space: the radius that
/// the view wants at the cube's farthest depth, or that of all the cube's splats.
double stp_cue_overhang(const stp_cue_view* view, const stp_leaf_node* node, const stp_boxd* box);

/// Splats wanted for a cube's pixels alone: W over the square of the splat size, which is W / 4 at
/// two pixels; STP_CUE_COVERING times as many for STP_CUE_ERROR_BIT. Of a cube of several leaves the
/// sum over these, as if they were spread evenly over its depths.
double stp_cue_nominal(const stp_cue_view* view, const stp_leaf_node* node,
                       const stp_box_visibility* sight);

/// Share of a cube's leaves that the view sees as silhouettes: some of such a leaf may face the eye
/// and some may face away. 0 or 1 of a leaf; of a cube an estimate from its range of normals.
double stp_cue_silhouette(const stp_cue_view* view, const stp_leaf_node* node);

/// Share of a cube's leaves some of which may mirror the light to the eye, likewise.
double stp_cue_highlight(const stp_cue_view* view, const stp_leaf_node* node);

/// Factor on samples by the cues that do not depend on the view: flatness and edges.
double stp_cue_shape(const stp_cue_view* view, const stp_leaf_node* node);

/// Splats of leaves between a cube's centre and the eye, weighted by the cosine at which the ray
/// meets their surface. Leaves that touch the cube do not count, nor do those that may continue its
/// surface. Stops at `enough`.
double stp_cue_before(const stp_cue_view* view, const stp_leaf_node* node, double enough);

/// Number of splats before a cube beyond which more make no difference; 0 without the cue.
double stp_cue_occlusion_limit(const stp_cue_view* view, const stp_leaf_node* node,
                               const stp_box_visibility* sight);

/// A ray to the eye that the leaves of a small cube share. Zeroed at first.
typedef struct stp_cue_ray {
    double before;  ///< splats before the cube, as stp_cue_before finds them
    uint32_t until; ///< first node outside the cube
} stp_cue_ray;

/// Traces the ray of a node, unless it is in the cube of the last one. A cube is asked before its
/// parts; only one of few leaves, or a `whole` one, whose parts are not asked, has a ray.
void stp_cue_trace(stp_cue_ray* last, const stp_cue_view* view, uint32_t index, bool whole,
                   const stp_box_visibility* sight);

/// What a view wants of a leaf by all cues, in splats, however many it has.
double stp_cue_importance(const stp_cue_view* view, const stp_leaf_node* node,
                          const stp_box_visibility* sight, double before);

/// Applies all cues: the number of splats, at most all. Of a cube of several leaves the sum of what
/// these want, if none of them wants all of its splats.
/// @param before splats before it, as stp_cue_before finds them for it or for a cube around it
double stp_cue_samples(const stp_cue_view* view, const stp_leaf_node* node,
                       const stp_box_visibility* sight, double before);

// Turns splat counts per leaf into items with runs.

/// A leaf, or consecutive leaves along the curve, and the number of its splats that are drawn: the
/// first ones in octave order.
typedef struct stp_cue_cell {
    uint32_t first, last; ///< places of the row of splats (base/splats/leaf_runs.h)
    uint32_t count;       ///< splats drawn, 1 to last - first
    // set by stp_cue_add_items:
    uint32_t growth; ///< splats are larger by a power of the fourth root of 2: the exponent
    uint32_t next;   ///< the next cell with the same growth
} stp_cue_cell;

/// Number of octaves of which all splats are loaded, if the first `here` are; at least 1.
uint32_t stp_cue_octaves(const stp_splats* set, uint32_t here);

/// The first `count` splats of a leaf or cube.
stp_cue_cell stp_cue_cell_make(const stp_leaf_node* node, uint32_t count);

/// Number of places in [first, last) of a row that are in the first `octaves` octaves.
uint32_t stp_cue_count(const stp_splats* set, uint32_t first, uint32_t last, uint32_t octaves);

/// Appends a cell to those of the list, unless it is empty. @param count cells so far, one more
/// afterwards
STP_MUST_USE stp_result stp_cue_add_cell(stp_selection* s, size_t* count, stp_cue_cell cell);

/// Distributes exactly `wanted` splats over all leaves of a set. With STP_CUE_IMPORTANCE_BIT a leaf
/// gets what the view wants of it, else its share of the area, which the paper's cues multiply by
/// flatness and edges. Leaves that have too few give all. Cubes whose leaves would get none are
/// cells as a whole, so that no part of the surface stays bare.
/// @param here splats loaded; `wanted` is at most as many
STP_MUST_USE stp_result stp_cue_share_out(stp_selection* s, const stp_cue_view* view,
                                          uint32_t wanted, uint32_t here, size_t* count);

/// Appends one item per splat size of the cells, otherwise a copy of `item`. Cells are in curve
/// order.
STP_MUST_USE stp_result stp_cue_add_items(stp_selection* s, const stp_splats* set,
                                          stp_cue_cell* cells, size_t count, stp_draw_item item,
                                          stp_depth_range drawn);
