// SPDX-License-Identifier: MIT
// Number of splats that a view takes from a leaf, or from a cube of several leaves: by the paper's
// five cues (Bhakar, Luo, Mudur 2004, 2 and Table 1), by coverage, and for highlights.
#pragma once

#include "select/select_internal.h"
#include "store/file/store.h"

/// Table 1.
/// flatness of a region with twice the samples of a flat one, the maximum
#define STP_CUE_FLATNESS 0.005
#define STP_CUE_FEATURE 4.0    ///< factor on samples at a silhouette or an edge
#define STP_CUE_OCCLUSION 0.01 ///< reduction by occluding points per pixel of a region

/// For STP_CUE_ERROR_BIT. Evenly spread points (lod/stochastic/leaf_passes.h) cover the surface
/// with disks of radius 1.05 times the side of each point's square. Takes as many points as make
/// that radius half a splat size.
#define STP_CUE_COVERING 4.41     ///< (2 x 1.05)^2 splats per square of the splat size
#define STP_CUE_ERROR_BENT 1.25   ///< maximum factor on samples of a bent region
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

/// Upper limit on how far splats of a cube extend beyond its box, in scene space: the radius that
/// the view wants at the cube's farthest depth, or that of all the cube's splats.
double stp_cue_overhang(const stp_cue_view* view, const stp_leaf_node* node, const stp_boxd* box);

/// Splats wanted for a cube's pixels alone: W over the square of the splat size, which is W / 4 at
/// two pixels; STP_CUE_COVERING times as many for STP_CUE_ERROR_BIT.
double stp_cue_nominal(const stp_cue_view* view, const stp_leaf_node* node,
                       const stp_box_visibility* sight);

/// Whether some of a cube may face the eye and some may face away.
bool stp_cue_silhouette(const stp_cue_view* view, const stp_leaf_node* node);

/// Whether some of a cube may mirror the light to the eye.
bool stp_cue_highlight(const stp_cue_view* view, const stp_leaf_node* node);

/// Splats of leaves between a cube's centre and the eye, weighted by the cosine at which the ray
/// meets their surface. Leaves that touch the cube do not count, nor do those that may continue its
/// surface. Stops at `enough`.
double stp_cue_before(const stp_cue_view* view, const stp_leaf_node* node, double enough);

/// Number of splats before a cube beyond which more make no difference; 0 without the cue.
double stp_cue_occlusion_limit(const stp_cue_view* view, const stp_leaf_node* node,
                               const stp_box_visibility* sight);

/// Applies all cues: the number of splats, at most all.
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

/// Finds the number of octaves whose share of the set's splats is nearest to `share`, at most that
/// of `here` splats. @return number of octaves
uint32_t stp_cue_octaves(const stp_splats* set, double share, uint32_t here);

/// Number of places in [first, last) of a row that are in the first `octaves` octaves.
uint32_t stp_cue_count(const stp_splats* set, uint32_t first, uint32_t last, uint32_t octaves);

/// Appends one item per splat size of the cells, otherwise a copy of `item`. Cells are in curve
/// order.
STP_MUST_USE stp_result stp_cue_add_items(stp_selection* s, const stp_splats* set,
                                          stp_cue_cell* cells, size_t count, stp_draw_item item,
                                          stp_depth_range drawn);
