// SPDX-License-Identifier: MIT
//
// Selects what to draw for a view: a pure function of scene, view, quality and occluders
// (docs/algorithms/select.md).
//
// Levels of detail change with depth. A node's splats suffice beyond a switch depth; nearer, its
// own triangles and its children are drawn. Around the switch depth both are drawn: each splat and
// triangle has its own switch depth, so nothing pops.
#pragma once

#include "select/depth_pyramid.h"
#include "select/eyes.h"
#include "select/visibility.h"
#include "store/residency/residency.h"

#include <stipple/view.h>

typedef enum stp_policy {
    STP_POLICY_INSERTION, ///< prefixes by insertion radius: no hole, with a guarantee
    STP_POLICY_PAPER,  ///< prefixes by the estimate p(r) = p_m (r_m / r)^2 (Brandt 4.1); switched
    STP_POLICY_SWITCH, ///< insertion, at the node's nearest depth, without blending between levels
} stp_policy;

/// Cues that decide the number of splats per leaf, for sets built leaf by leaf (select/cues.h).
enum {
    STP_CUE_FLATNESS_BIT = 1, ///< more on curved surfaces
    STP_CUE_EDGE_BIT = 2,     ///< more at possible edges
    /// By the leaf's pixels; without it, all leaves count as near as the nearest
    STP_CUE_COVERAGE_BIT = 4,
    STP_CUE_SILHOUETTE_BIT = 8, ///< more at possible silhouettes
    STP_CUE_OCCLUSION_BIT = 16, ///< fewer for occluded leaves
    /// By coverage of the samples' splats, not by the paper's numbers: see STP_CUE_COVERING.
    STP_CUE_ERROR_BIT = 32,
    STP_CUE_SPECULAR_BIT = 64, ///< more where a polished surface may show a highlight
    /// Importance sampling (Bhakar 2004, 5): a number of splats goes to the leaves in proportion to
    /// what the view needs of them, not to their area.
    STP_CUE_IMPORTANCE_BIT = 128,
    STP_CUES_ALL = 255,
    STP_CUES_PAPER = 31, ///< Table 1 as it is printed
};

/// Bound on what a frame may have to draw, compared with the list of its first pass and with that of
/// both, without large triangles. All zero: none.
typedef struct stp_work_limit {
    double splat, triangle, item; ///< work of each that is listed
    double most;                  ///< a list of more work is not drawn (stp_draw_stats.exceeds)
} stp_work_limit;

typedef struct stp_quality {
    float splat_size; ///< pixels, at least 1; default 1
    /// Exact total number of splats instead, or all if there are fewer; an upper limit for `spt`.
    /// 0: by size. Takes splats from the topmost sets of the shown scene, in view or not; content
    /// without splats is drawn as triangles and points.
    uint64_t splat_count;
    stp_policy policy;
    /// Method whose sets are drawn (STP_METHOD_*). 0: the file's first, together with
    /// stp_select_coarse_method. A method that the file lacks: the file's first alone.
    uint32_t method;
    bool reference;   ///< original triangles and points only
    bool splats_only; ///< a node that has splats is never opened, however near it is
    bool nodes_only;  ///< a node is drawn as splats or as triangles, never as a mix
    bool all_sides;   ///< back-facing splats are drawn too (stp_draw_item.one_sided)
    /// Sets that show points and triangles together are not drawn: their splats have no attributes,
    /// and no fixed size.
    bool points_apart;
    uint32_t cues_off; ///< ignored STP_CUE_*_BIT
    stp_fovea fovea;   ///< all zero: splats are of one size
    /// A node may be opened while its splats could still cover this many times better than
    /// required, if they number at least 1/STP_TRIANGLES_PER_SPLAT of its triangles: 1 to 8; 0: 8.
    float early_switch;
    /// Optional occluders, one pyramid per eye of the view. Nodes occluded for every eye that sees
    /// them are left out. See stp_select_rejected.
    const stp_depth_pyramid* occlusion;
    /// NULL: everything is shown. Must be of the same store, and must not change while the list is
    /// in use.
    const stp_visibility* visibility;
    stp_work_limit limit; ///< of the list for all eyes; decides nothing but whether it is drawn
} stp_quality;

/// Whether two qualities select the same from the same view, if the same is hidden: occlusion and
/// visibility are not compared, nor limits.
bool stp_quality_is_same(const stp_quality* a, const stp_quality* b);

typedef enum stp_draw_kind { STP_DRAW_SPLATS, STP_DRAW_MESH, STP_DRAW_POINTS } stp_draw_kind;

/// One item to draw. Ids in the visibility buffer are frame-local: first_id + splat or triangle.
///
/// Depths are along the viewing direction, in scene units (the raster matrix's W); 1 in parallel
/// projection.
typedef struct stp_draw_item {
    stp_draw_kind kind;
    uint32_t index;  ///< splat set, mesh or point set of the store
    uint32_t prefix; ///< maximum number of splats or points drawn
    /// Splats: prefix whose colours and coverages are used; at least `prefix`
    uint32_t full_prefix;
    uint32_t first_id;
    uint32_t first_run, run_count; ///< runs in the list; none: every splat of the prefix is drawn
    float radius; ///< radius of each splat, in item space; for splats with shapes, a typical one
    /// Levels compared with splat ranges: the error in item space allowed at depth 1, and the error
    /// allowed anywhere. Unused for sets without ranges.
    float level_per_depth, level_min;
    // State of a set refined by splits (base/splats/progressive.h): splats before `divide` are
    // compared with another level.
    uint32_t divide;   ///< 0: one level for all, as in all other sets
    float level_below; ///< level of splats [0, divide), at any depth
    /// Splats of the prefix outside the state, or in no run of a scattered item
    uint32_t split_count;
    float shape_scale; ///< factor on radii of splats with shapes; 0: 1
    bool scattered;    ///< its runs begin and end anywhere, and share one depth range
    /// Mesh: a level (stp_store_directory.levels), of which each cluster is drawn where the allowed
    /// error, by level_per_depth and level_min, is between those of its groups, and its farthest
    /// depth is at least level_from.
    bool is_level;
    uint32_t level;
    float level_from;
    /// Mesh: draws triangles whose level (store/sets/large_triangles.h) is at least the item's
    /// level at their nearest corner. Such items follow the item of the set beside which they are
    /// drawn.
    bool large;
    float large_min;       ///< no view draws triangles of a lower level beside this set
    float large_from;      ///< this view draws no triangles of a lower level
    bool beside_triangles; ///< splats: omits those that large triangles replace
    /// Mesh: all triangles are drawn nearer than switch_begin, none beyond switch_end
    /// (stp_draw_share); 0, 0: all. Large triangles: none whose nearest corner is nearer than
    /// switch_begin, since another item draws the whole mesh there.
    float switch_begin, switch_end;
    uint32_t sections; ///< bits of the view's planes that may cut it; 0: none
    bool ghost;        ///< drawn in a share of its pixels (stp_draw_style.ghost)
    bool one_sided;    ///< splats: back faces may be culled; all sides of the surface have splats
    bool of_points;    ///< draws original points, also as splats: their size may be fixed
    stp_affine transform; ///< to scene space
} stp_draw_item;

/// Splats [begin, end) of an item are drawn if nearest <= depth of the centre <= farthest; splats
/// in no run are not drawn. Runs ascend. They begin and end at multiples of 64, or with the prefix;
/// in scattered items anywhere.
typedef struct stp_draw_run {
    uint32_t begin, end;
    float nearest, farthest;
} stp_draw_run;

typedef struct stp_draw_list {
    stp_draw_item* items;
    size_t count, capacity;
    stp_draw_run* runs;
    size_t run_count, run_capacity;
    /// Earlier items are from stp_select, later ones from stp_select_rejected
    size_t first_pass_count;
    uint64_t splat_count;     ///< splats of prefixes; for sets refined by splits, of their states
    uint64_t triangle_count;  ///< without large triangles
    uint64_t id_count;        ///< ids of all items; less than 2^32
    uint64_t extra_splats;    ///< part of splat_count, listed only by level switches
    uint64_t extra_triangles; ///< the same of triangle_count
    uint32_t node_count;      ///< visited nodes
    uint32_t hidden_count;    ///< nodes that the pyramid occluded, in the last pass
    float splat_size;         ///< splat size used at the gaze point
    bool mixes; ///< splats and triangles may occur together, in this list or in another view's
    /// Streaming store: resources that the view would draw, loaded or not, each once
    /// (stp_residency_update).
    stp_data_request* requests;
    size_t request_count;
    // reused between calls
    uint32_t* request_slots; ///< per resource of the store: 1 + index of its request; 0: none
    size_t want_capacity;
    struct stp_select_entry *stack, *rejected;
    size_t stack_capacity, rejected_count, rejected_capacity;
    struct stp_select_graph* graph; ///< owned: properties of the nodes of the list's store
    struct stp_select_cut* cuts;    ///< cached states of progressive sets, in the order of use
    size_t cut_capacity;
    struct stp_select_share* shares; ///< for the splat count
    size_t share_capacity;
    struct stp_cue_cell* cells; ///< cells of the last added set
    struct stp_cue_part* parts; ///< of its nodes, when a number of splats is distributed
    size_t part_capacity;
    size_t cell_capacity;
} stp_draw_list;

/// Share of a mesh item's triangles drawn at a depth: the nearest depth of their cluster (or mesh).
static inline float stp_draw_share(const stp_draw_item* item, float depth)
{
    if (!(item->switch_end > 0.0f) || depth <= item->switch_begin) {
        return 1.0f;
    }
    return depth >= item->switch_end
               ? 0.0f
               : (item->switch_end - depth) / (item->switch_end - item->switch_begin);
}

/// Whether triangle `index` of a mesh belongs to a share of its triangles. Larger shares include
/// smaller ones.
static inline bool stp_draw_keeps(uint32_t index, float share)
{
    uint32_t h = index * 0x9E3779B1u;
    h = (h ^ h >> 15) * 0x2C1B3C6Du;
    h ^= h >> 13;
    return (float)(h >> 8) < share * 16777216.0f;
}

/// Coarse method: its sets represent nodes that need only a small share of their own sets. It is
/// `psp` beside `blue`, or else a few ellipses of the uppermost sets, if the quality leaves the
/// choice to the file. A few merged ellipses cover flat and long shapes better than disks
/// (docs/notes/2026-11-coarse-ellipses.md, docs/notes/2026-11-few-splats.md). @return its
/// index in the directory's table; STP_STORE_NONE: none
uint32_t stp_select_coarse_method(const stp_store_directory* directory, const stp_quality* quality);

/// Fills `list`. Zero-initialize it; its memory is reused between calls (stp_draw_list_destroy),
/// and it belongs to one store. Items outside the view are culled. A node is opened to the extent
/// that its splats cannot cover at the wanted size, and fully if the eye is inside it: its own
/// triangles and points are drawn, and its children visited. Point nodes whose splats include
/// every point are never opened. A node's splats exclude moving nodes below it: these are visited
/// separately, with their own splats if they have any, even if an ancestor is drawn.
///
/// The list of a view with two eyes holds the items that either eye needs, as fine as the nearer
/// eye needs them. It is drawn once per eye, with the views of select/eyes.h.
///
/// For a streaming store (store/residency/residency.h), only resident data is drawn: a node is
/// opened only if everything below it has a resident level, and a partly resident set is drawn with
/// larger splats. References ignore residency.
///
/// A splat count is distributed by area over the topmost sets of the shown scene, including those
/// outside the view: each gets one splat before any gets two. Below them only moving nodes are
/// drawn, whose sets have shares of their own. Content that no such set represents (it has no set,
/// and its ancestors' sets contain hidden objects) is drawn as original geometry. Sets of `psp` are
/// read as far as their states reach.
///
/// With a pyramid, nodes that it occludes are deferred. The pyramid may be of any earlier frame:
/// stp_select_rejected finds wrongly deferred nodes.
/// @return STP_OK, STP_ERROR_ARGUMENT (an invalid view, fovea or section), STP_ERROR_LIMIT (more
/// than 2^32 - 2 splats and triangles, or too many nodes, items or runs),
/// STP_ERROR_OUT_OF_MEMORY, or as stp_store_get_splat_set_prefix; logged
STP_MUST_USE stp_result stp_select(stp_context* context, stp_store* store, const stp_view* view,
                                   const stp_quality* quality, stp_draw_list* list);

/// The second pass. `list` was filled by stp_select for the same view and quality. Appends the
/// deferred nodes that `quality->occlusion` (now built from the first pass's picture; NULL: no
/// occluders) does not occlude. Earlier items keep their places and ids; first_pass_count is their
/// number. Both passes together give the same picture as a selection without a pyramid, except at
/// equal depths.
STP_MUST_USE stp_result stp_select_rejected(stp_context* context, stp_store* store,
                                            const stp_view* view, const stp_quality* quality,
                                            stp_draw_list* list);
void stp_draw_list_destroy(stp_context* context, stp_draw_list* list);

/// Number of splats in the largest state of a set of `psp`: the whole set less the parents. Reads
/// octaves until the base set ends.
/// @param maximum receives the number; the set's count if it has no ranges or nothing can be read
/// @param ends whether the end of the base set is known; else more octaves may give another count
/// @return STP_OK, or as stp_store_get_splat_set_prefix
STP_MUST_USE stp_result stp_select_count_states(stp_store* store, uint32_t set, uint32_t* maximum,
                                                bool* ends);
