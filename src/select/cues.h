// SPDX-License-Identifier: MIT
// How many splats of a leaf, or of a cube of several, a view takes: from five cues (Bhakar, Luo, Mudur 2004, 2 and Table 1).
#pragma once

#include "select/select_internal.h"
#include "store/leaves.h"

/// Table 1.
#define STP_CUE_FLATNESS                                                                           \
    0.005                   ///< of a region with twice the samples of a flat one, which is the most
#define STP_CUE_FEATURE 4.0 ///< times the samples where there is a silhouette or an edge
#define STP_CUE_OCCLUSION                                                                          \
    0.01 ///< of the points before a region for each of its pixels: what is left out

/// By STP_CUE_ERROR_BIT. Points that are spread evenly (lod/stochastic/spread_order.h) leave nothing uncovered by disks whose
/// radius is 1.05 sides of the square that each stands for. So as many are taken as make that radius half a splat size.
#define STP_CUE_COVERING 4.41     ///< (2 x 1.05)^2 splats to a square of the splat size
#define STP_CUE_ERROR_BENT 1.25   ///< times the samples of a bent region, at the most
#define STP_CUE_ERROR_FEATURE 1.5 ///< where there is a silhouette, an edge or a highlight
#define STP_CUE_HIGHLIGHT 0.26 ///< sine of how far from the mirror's direction a highlight reaches

/// What is known of a set in a view.
typedef struct stp_cue_view {
    const stp_selection* s;
    const stp_select_entry* at;
    const stp_splats* set;
    const stp_store_leaves* leaves;
    const stp_sight* sight; ///< of the whole set
    uint32_t cues;          ///< STP_CUE_*_BIT
    double scale;           ///< of lengths, to scene space
    stp_vec3d eye;          ///< on the grid; in parallel projection the direction towards it
    stp_vec3d light;        ///< to the light, in the space of the set
    bool flat_view;         ///< parallel projection
    bool polished;          ///< some of its surfaces may show highlights
} stp_cue_view;

/// @param sight of the node
stp_cue_view stp_cue_view_make(const stp_selection* s, const stp_select_entry* at,
                               const stp_splats* set, const stp_store_leaves* leaves,
                               const stp_sight* sight);

/// The box of a cube of the octree, in scene space.
stp_boxd stp_cue_box(const stp_cue_view* view, const stp_leaf_node* node);

/// What of a cube's splats is wanted by its pixels alone: W over the square of the splat size, which is W / 4 at two pixels;
/// STP_CUE_COVERING times as many by STP_CUE_ERROR_BIT.
double stp_cue_nominal(const stp_cue_view* view, const stp_leaf_node* node, const stp_sight* sight);

/// What flatness and edges make of a number of samples: cues that do not depend on the view.
double stp_cue_shape(const stp_cue_view* view, const stp_leaf_node* node, double samples);

/// Whether some of a cube may face the eye and some may face away.
bool stp_cue_silhouette(const stp_cue_view* view, const stp_leaf_node* node);

/// Whether some of a cube may mirror the light to the eye.
bool stp_cue_highlight(const stp_cue_view* view, const stp_leaf_node* node);

/// How much stands before a cube, between 0 and 1, from the splats of the leaves between its middle and the eye, and the pixels it
/// covers. Leaves that touch the cube, and what is seen edge-on, do not hide it.
double stp_cue_occlusion(const stp_cue_view* view, const stp_leaf_node* node, double pixels);

/// All cues together: how many splats, at most all.
double stp_cue_samples(const stp_cue_view* view, const stp_leaf_node* node, const stp_sight* sight);
