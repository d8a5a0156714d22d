// SPDX-License-Identifier: MIT
//
// What to draw for a view: a pure function of scene, view, quality and what hides (design.md, section 5).
//
// Levels meet in depth. A node's surfels suffice from some depth on; nearer than that its own triangles and its children
// are drawn, and around it both, each splat and triangle from a depth of its own on, so that nothing pops.
#pragma once

#include "select/depth_pyramid.h"
#include "select/eyes.h"
#include "select/fovea.h"
#include "select/visibility.h"
#include "store/residency.h"

#include <stipple/view.h>

typedef enum stp_policy {
    STP_POLICY_INSERTION, ///< prefixes by insertion radius: no hole, with a guarantee
    STP_POLICY_PAPER,  ///< prefixes by the estimate p(r) = p_m (r_m / r)^2 (Brandt 4.1); switched
    STP_POLICY_SWITCH, ///< insertion, at the node's nearest depth, without blending between levels
} stp_policy;

/// What decides how many splats of a leaf are drawn, of sets that were made leaf by leaf (select/cues.h).
enum {
    STP_CUE_FLATNESS_BIT = 1, ///< more where the surface bends
    STP_CUE_EDGE_BIT = 2,     ///< and where there may be an edge
    STP_CUE_COVERAGE_BIT =
        4, ///< by the pixels of the leaf; without, all leaves are as near as the nearest
    STP_CUE_SILHOUETTE_BIT = 8, ///< more where some of it may face away
    STP_CUE_OCCLUSION_BIT = 16, ///< fewer where much stands before it
    /// By how far the samples' splats cover, not by the paper's numbers: see STP_CUE_COVERING.
    STP_CUE_ERROR_BIT = 32,
    STP_CUE_SPECULAR_BIT = 64, ///< more where a polished surface may show a highlight
    STP_CUES_ALL = 127,
    STP_CUES_PAPER = 31, ///< Table 1 as it is printed
};

typedef struct stp_quality {
    float splat_size; ///< pixels, at least 1; default 1
    /// Exactly so many splats instead, in all, or what there is; of `spt`, at most so many. 0: by
    /// size. They are those of the uppermost sets of what is shown, seen or not; what has no splats
    /// is drawn by its triangles and points.
    uint64_t splat_count;
    stp_policy policy;
    /// Whose sets are drawn (STP_METHOD_*). 0: those of the file's first, and beside it of stp_select_coarse_method. None of
    /// the file's: those of its first alone.
    uint32_t method;
    bool reference;   ///< original triangles and points only
    bool splats_only; ///< a node that has splats is never opened, however near it is
    bool nodes_only;  ///< a node is drawn by splats or by triangles, never by some of both
    bool all_sides;   ///< splats that face away are drawn as well (stp_draw_item.one_sided)
    /// Sets that show points and triangles together are not drawn: their splats have no attributes, and no fixed size.
    bool points_apart;
    uint32_t cues_off; ///< STP_CUE_*_BIT that are not looked at
    stp_fovea fovea;   ///< all zero: splats are of one size
    /// A node is opened where its surfels could still cover so many times better than they have to, provided that
    /// they number at least 1/STP_TRIANGLES_PER_SURFEL of its triangles there: 1 to 8; 0: 8.
    float spare;
    /// NULL, or what hides from each eye of the view: nodes behind it for all that see them are left out. See
    /// stp_select_rejected.
    const stp_depth_pyramid* occlusion;
    /// NULL: all is shown. Of the same store; while the list is in use it must not change.
    const stp_visibility* visibility;
} stp_quality;

typedef enum stp_draw_kind { STP_DRAW_SURFELS, STP_DRAW_MESH, STP_DRAW_POINTS } stp_draw_kind;

/// One thing to draw. Ids in the visibility buffer are frame-local: first_id + splat or triangle.
///
/// Depths are along the gaze, in scene units (the raster matrix's W); 1 in parallel projection.
typedef struct stp_draw_item {
    stp_draw_kind kind;
    uint32_t index;  ///< surfel set, mesh or point set of the store
    uint32_t prefix; ///< surfels or points drawn, at most
    uint32_t
        full_prefix; ///< surfels: the prefix whose colours and coverages they have; at least `prefix`
    uint32_t first_id;
    uint32_t first_run, run_count; ///< of the list's runs; none: each splat of the prefix is drawn
    float radius; ///< of each splat, in the space of the item; of those with shapes, a usual one
    /// The levels that ranges of splats are held against: an error in the item's space that is allowed at depth 1, and one
    /// that is allowed anywhere. Of sets without ranges they mean nothing.
    float level_per_depth, level_least;
    // A state of a set that is refined by splits (base/progressive.h): splats before `divide` are held against another level.
    uint32_t divide;   ///< 0: there is one level for all, as with all other sets
    float level_below; ///< of splats [0, divide), anywhere
    uint32_t
        split_count; ///< splats of the prefix that are not of the state, or in no run of a scattered item
    float shape_scale; ///< radii of splats with shapes are so many times larger; 0: 1
    bool scattered;    ///< its runs begin and end anywhere, and have one range of depths
    /// Mesh: of its triangles those are drawn whose level (store/large_triangles.h) is at least that of the item at their
    /// nearest corner. Such items follow that of the set that they are drawn beside.
    bool large;
    float large_least;     ///< no view draws one of a lower level from this set
    float large_from;      ///< this view draws none of a lower level
    bool beside_triangles; ///< surfels: those that large triangles replace are left out
    /// Mesh: nearer than fade_begin all triangles are drawn, beyond fade_end none (stp_draw_share). 0, 0: all. Large ones: none
    /// whose nearest corner is nearer than fade_begin: another item draws all of the mesh there.
    float fade_begin, fade_end;
    uint32_t sections; ///< bits of the view's planes that may cut it; 0: it lies inside them all
    bool ghost;        ///< drawn in some of its pixels only (stp_draw_style.ghost)
    bool one_sided; ///< surfels: what faces away need not be drawn; all sides of a thing have some
    bool of_points; ///< splats are original points, or these are drawn: their size may be fixed
    stp_affine transform; ///< to scene space
} stp_draw_item;

/// Splats [begin, end) of an item are drawn where nearest <= depth of the centre <= farthest; those in no run are not drawn.
/// Runs ascend. They begin and end at multiples of 64, or with the prefix; of scattered items anywhere.
typedef struct stp_draw_run {
    uint32_t begin, end;
    float nearest, farthest;
} stp_draw_run;

typedef struct stp_draw_list {
    stp_draw_item* items;
    size_t count, capacity;
    stp_draw_run* runs;
    size_t run_count, run_capacity;
    size_t
        first_pass_count; ///< items before are those of stp_select, the others of stp_select_rejected
    uint64_t splat_count; ///< of prefixes; of states of sets that are refined by splits, of these
    uint64_t triangle_count;  ///< without large triangles
    uint64_t id_count;        ///< of all items
    uint64_t extra_splats;    ///< of splat_count, listed because levels blend
    uint64_t extra_triangles; ///< the same of triangle_count
    uint32_t node_count;      ///< nodes looked at
    uint32_t hidden_count;    ///< nodes that the pyramid hid, in the last pass
    float splat_size;         ///< the size in effect where an eye looks
    bool mixes; ///< there may be splats beside triangles, in this list or in one of another view
    /// Of a store that streams, each thing once: what the view would draw, here or not (stp_residency_update).
    stp_want* wants;
    size_t want_count;
    // kept between calls
    uint32_t* want_slots; ///< of each thing of the store, its want's place and 1; 0: none
    size_t want_capacity;
    struct stp_select_entry *stack, *rejected;
    size_t stack_capacity, rejected_count, rejected_capacity;
    struct stp_select_graph* graph; ///< of the store that the list is used with
    struct stp_select_cut* cuts;    ///< the last ones, in the order of items
    size_t cut_capacity;
    struct stp_select_share* shares; ///< of the count of splats
    size_t share_capacity;
    struct stp_cue_cell* cells; ///< of the set that was added last
    size_t cell_capacity;
} stp_draw_list;

/// The part of a mesh item's triangles that is drawn at a depth: where the cluster (or mesh) they belong to is nearest.
static inline float stp_draw_share(const stp_draw_item* item, float depth)
{
    if (!(item->fade_end > 0.0f) || depth <= item->fade_begin) {
        return 1.0f;
    }
    return depth >= item->fade_end ? 0.0f
                                   : (item->fade_end - depth) / (item->fade_end - item->fade_begin);
}

/// Whether triangle `index` of a mesh is among a share of its triangles. Each is from some share on.
static inline bool stp_draw_keeps(uint32_t index, float share)
{
    uint32_t h = index * 0x9E3779B1u;
    h = (h ^ h >> 15) * 0x2C1B3C6Du;
    h ^= h >> 13;
    return (float)(h >> 8) < share * 16777216.0f;
}

/// The method whose sets stand for nodes that need a small share of their own sets: `psp` beside `blue`, where the quality
/// leaves the choice to the file. Merged ellipses cover flat and long things better than disks as long as they are few
/// (docs/notes/2026-11-coarse-ellipses.md). @return its place in the directory's table; STP_STORE_NONE: there is none
uint32_t stp_select_coarse_method(const stp_store_directory* directory, const stp_quality* quality);

/// Fills `list`; its memory is kept from call to call (stp_draw_list_destroy; all zero at first), and it belongs
/// to one store. Items outside the view are left out. A node is opened as far as its surfels cannot cover at the wanted
/// size, and wholly where the eye is within it: its own triangles and points are drawn, and its children looked
/// at. Points whose surfels are all of them are never opened. Surfels show nothing that moves below their node:
/// what does is looked at by itself, with its own surfels where it has some, also below a node that is drawn.
///
/// The list of a view with two eyes holds what either needs, as fine as the one needs it that is nearer: it is drawn
/// once for each eye, with the views of select/eyes.h.
///
/// Of a store that streams (store/residency.h), what is resident is drawn: a node whose stand-ins are not all here is
/// not opened, and a set that is not all here is drawn as far as it is, with larger splats. References take no notice.
///
/// A count of splats is shared by area among the uppermost sets of what is shown, also those outside
/// the view: each gets one splat before any gets two. Nothing below them is drawn but what moves,
/// whose sets have their shares. What no such set stands for (it has no set, and those above it show
/// what is hidden) is drawn as it is. Sets of `psp` are read as far as their states reach.
///
/// With a pyramid, nodes that it hides are set aside. It may be of any earlier frame: what it hides wrongly is
/// found by stp_select_rejected.
/// @return STP_OK, STP_ERROR_ARGUMENT (a view or a fovea that is none), STP_ERROR_LIMIT (more than 2^32 - 2 splats and
/// triangles), STP_ERROR_OUT_OF_MEMORY, or as stp_store_get_surfels_prefix; logged
STP_MUST_USE stp_result stp_select(stp_context* context, stp_store* store, const stp_view* view,
                                   const stp_quality* quality, stp_draw_list* list);

/// The second pass: appends to `list`, which stp_select filled for the same view and quality, what that call set aside
/// and `quality->occlusion` (now made of the picture of the first pass; NULL: nothing) does not hide. Items before
/// keep their places and ids, and first_pass_count says how many they are. Both passes' items drawn together give the
/// picture that selecting without a pyramid gives, but for what lies at equal depths.
STP_MUST_USE stp_result stp_select_rejected(stp_context* context, stp_store* store,
                                            const stp_view* view, const stp_quality* quality,
                                            stp_draw_list* list);
void stp_draw_list_destroy(stp_context* context, stp_draw_list* list);

/// How many splats the largest state of a set of `psp` has: as many as the whole set has, less the
/// parents. Reads octaves until the base set ends.
/// @param most the count of the set where it has no ranges or nothing can be read
/// @param ends whether the end of the base set is known; else more octaves may give another count
/// @return STP_OK, or as stp_store_get_surfels_prefix
STP_MUST_USE stp_result stp_select_count_states(stp_store* store, uint32_t set, uint32_t* most,
                                                bool* ends);
