// SPDX-License-Identifier: MIT
// Shared by the parts of selection: the state of a call, and decisions about a node.
#pragma once

#include "select/sections.h"
#include "select/select.h"

// The level switch: around the switch depth, from which a set suffices, the set and the content below
// replace each other gradually.
/// Factor on the switch depth: the content below is drawn up to there, the share of it that is drawn
/// falls from the switch depth on.
#define STP_LEVEL_SWITCH_FAR 1.1
/// Shortfall of the wanted radius at which no splat of the set is drawn.
#define STP_LEVEL_SWITCH_SHORTFALL 1.07
#define STP_LEVEL_SWITCH_SHORTFALL_SQUARED (STP_LEVEL_SWITCH_SHORTFALL * STP_LEVEL_SWITCH_SHORTFALL)
/// Divides the switch depth: nearer than that the set is gone. The switch depth grows at least with
/// the cube of the shortfall (rule_blue.c).
#define STP_LEVEL_SWITCH_NEAR                                                                      \
    (STP_LEVEL_SWITCH_SHORTFALL_SQUARED * STP_LEVEL_SWITCH_SHORTFALL_SQUARED)

/// Cost of a splat relative to a triangle (docs/notes/2026-11-proportion.md).
#define STP_SPLAT_WORK 1.5
/// Limit on the work of a node in its level switch, relative to the more expensive of the two levels.
#define STP_LEVEL_SWITCH_WORK 1.2

/// Maximum and default of stp_quality.early_switch.
#define STP_EARLY_SWITCH_MAX 8.0

static inline double stp_select_early_switch(const stp_quality* quality)
{
    double factor = (double)quality->early_switch;
    return !(factor > 0.0) ? STP_EARLY_SWITCH_MAX : fmin(fmax(factor, 1.0), STP_EARLY_SWITCH_MAX);
}

/// Splat sizes, in pixels, for which opens_below is found; between them it is interpolated.
#define STP_OPENS_FINE 2.0
#define STP_OPENS_COARSE 16.0

enum { STP_LEVEL_ERRORS = 24 }; ///< in each row of level_counts

/// A node to visit.
typedef struct stp_select_entry {
    uint32_t node;
    bool moving_only;             ///< an ancestor's splats represent everything that does not move
    bool in_level_switch;         ///< drawn only by a level switch: an ancestor's splats suffice
    uint32_t sections;            ///< bits of section planes that may cut it
    uint32_t shown;               ///< state of its visibility
    double ancestor_switch_depth; ///< beyond it an ancestor's splats suffice
    /// Beyond it an ancestor's levels stand for opaque triangles; infinite: no ancestor has any
    double level_depth;
    double covered; ///< coverage radius of the nearest ancestor's set, scene units; infinite: none
    double eager;   ///< factor on the loading priority of the content below
    stp_affine transform;
} stp_select_entry;

/// View-independent properties of a store's nodes. Children come before their parents.
typedef struct stp_select_graph {
    const stp_store_directory* directory;
    const stp_store_node* nodes;
    uint32_t node_count, edge_count, part_count, set_count;
    uint32_t method; ///< index of the sets' method in the directory's table
    uint8_t* moving; ///< STP_NODE_MOVES, STP_MOVES_BELOW
    /// Overhang of a node's drawn content beyond its box, without pixels; node units
    float* margins;
    double* reaches;       ///< coverage radius of all splats of its own, node units
    float* early_switches; ///< factor on that radius: lower limit of their use
    float* works;          ///< maximum work of the content drawn instead of them, in triangles
    uint8_t* repeated;     ///< per part, one bit: whether its node listed it before
    bool* has_sets;        ///< it or a node below it has a set
    uint32_t* maximum;     ///< splats available in its set; 0: not known yet
    bool* others;          ///< whether there is anything below that levels do not replace
    float* level_floors;   ///< error from which its levels replace its originals; 0: it has none
    /// Two per node: levels below are drawn instead of splats of a smaller radius, where splats of
    /// STP_OPENS_FINE and of STP_OPENS_COARSE pixels are wanted; 0: none
    float* opens_below;
    float* level_overhangs; ///< how far spheres of their groups reach beyond its box
    uint32_t* level_rows;   ///< row of its levels in level_counts; STP_STORE_NONE: it has none
    /// Rows of STP_LEVEL_ERRORS: triangles of all levels that are drawn where errors of the diagonal
    /// of the node's box, half of it and so on are allowed
    float* level_counts;
    float* level_areas; ///< per row: estimate of the area of the node's surface
} stp_select_graph;

enum { STP_NODE_MOVES = 1, STP_MOVES_BELOW = 2 };

typedef struct stp_selection {
    stp_context* context;
    stp_store* store; ///< read-only, but may load a set's columns (cuts.c) or leaves
    const stp_store_directory* directory;
    const stp_quality* quality;
    const stp_sections* sections;
    stp_draw_list* list;
    uint32_t method; ///< index of the drawn method in the directory's table
    const struct stp_select_rule* rule;
    uint32_t coarse_method; ///< the same for the coarse method; STP_STORE_NONE: none
    const stp_select_graph* graph;
    stp_view_frame frames[STP_EYES_MAX]; ///< per eye, with common direction, scale and near plane
    uint32_t eye_count;
    size_t stack_count;
    uint64_t visits;
    size_t cut_count;   ///< states used in this call, from the list's cache
    size_t share_count; ///< sets registered for a splat count
    bool second_pass;
    bool draws_levels; ///< nodes that have levels are drawn by these
    bool streams;      ///< streaming: draws resident data, and requests the rest
} stp_selection;

/// Depths between which a box is seen; both 1 in parallel projection.
typedef struct stp_depth_range {
    double near, far;
} stp_depth_range;

/// Visibility of a box in a view.
typedef struct stp_box_visibility {
    stp_depth_range range; ///< combined over the eyes that see it
    uint32_t eyes;         ///< bits of the eyes that may see it
    bool is_inside;        ///< an eye is inside
    double splat_size;     ///< pixels: minimum wanted size in view
    double largest_size;   ///< maximum size in view, at least that at the gaze point
} stp_box_visibility;

/// How a node's splats are used. They are drawn beyond switch_depth; the node's content is drawn
/// nearer.
typedef struct stp_set_use {
    const struct stp_select_rule* rule;
    uint32_t set; ///< index in the store
    const stp_splats* splats;
    uint32_t count;                    ///< prefix; 0: not drawn
    uint32_t state;                    ///< requested number of splats, at any depth; 0: by size
    double radius;                     ///< radius of its splats, node units
    double level_per_depth, level_min; ///< levels of the item (stp_draw_item), node units
    double per_depth;     ///< the wanted coverage radius at depth 1, node units; 0: not by depth
    double switch_depth;  ///< 0: nothing below is drawn; infinite: everything
    bool in_level_switch; ///< not drawn without a level switch
} stp_set_use;

/// The set of a node, of the drawn method.
static inline uint32_t stp_select_set_of(const stp_selection* s, uint32_t node)
{
    return stp_store_set_of(s->directory, s->method, node);
}

/// @return whether any eye may see part of the box
bool stp_select_is_in_view(const stp_selection* s, const stp_boxd* box, stp_box_visibility* sight);

/// Bounding box of a transformed box.
stp_boxd stp_select_place_box(const stp_affine* transform, const stp_boxd* box);
/// The box of a node's mesh or points, in scene space.
stp_boxd stp_select_part_box(const stp_selection* s, stp_store_part part,
                             const stp_affine* transform);

// Streaming stores (resident.c).
/// Clears the list's requests, except in the second pass.
STP_MUST_USE stp_result stp_select_begin_requests(stp_selection* s);
/// Requests the part of an optional set that a use needs. @return whether it is resident
bool stp_select_request_coarse(stp_selection* s, const stp_select_entry* at,
                               const stp_box_visibility* sight, const stp_set_use* use);
/// Requests a mesh or points of a node. @return whether they are resident
bool stp_select_request_part(stp_selection* s, stp_store_part part, const stp_select_entry* at,
                             const stp_box_visibility* sight);
/// Requests the leaves of a node's set. stp_store_get_leaves returns the resident ones.
void stp_select_request_leaves(stp_selection* s, const stp_select_entry* at,
                               const stp_box_visibility* sight, uint32_t set);
/// Requests a mesh that only improves the picture, with the lowest priority. @return whether it is
/// resident
bool stp_select_request_optional_mesh(stp_selection* s, uint32_t mesh);
/// Turns the entry of a node with a set into the entry of its children.
void stp_select_cover(const stp_selection* s, const stp_splats* splats,
                      const stp_box_visibility* sight, stp_select_entry* at);
/// Limits the use of a node's splats to resident data, and requests what is missing.
STP_MUST_USE stp_result stp_select_limit_use(stp_selection* s, const stp_select_entry* at,
                                             const stp_box_visibility* sight, stp_set_use* use);

/// Requests a level of a node. @param error  that shows without it, node units. @return whether it is
/// resident
bool stp_select_request_level(stp_selection* s, const stp_select_entry* at,
                              const stp_box_visibility* sight, uint32_t mesh, double error);

// Levels of triangles (triangle_levels.c).

/// How a node's levels are used.
typedef struct stp_levels_use {
    double per_depth;         ///< allowed error at depth 1, node units
    double nearest, farthest; ///< allowed errors at the nearest and farthest depth
    double floor;             ///< least error that loaded levels can show
    double originals_to;      ///< depth up to which originals are drawn
} stp_levels_use;

/// Whether a view draws levels at all.
bool stp_select_draws_levels(const stp_selection* s);
/// Draws the levels of a node, if it has any and they look like the originals in this view: appends
/// their items, and sets the entry's level_depth.
STP_MUST_USE stp_result stp_select_use_levels(stp_selection* s, stp_select_entry* at,
                                              const stp_box_visibility* sight);
/// Requests the levels of a node. @return whether the node is drawn by levels, once they are
/// resident; `*here`: whether they are, finely enough
bool stp_select_request_levels(stp_selection* s, const stp_select_entry* at, bool* here);
/// Requests the visible meshes of a node and all below it that levels replace, or the other parts,
/// up to a depth. @param here  receives whether all are resident
STP_MUST_USE stp_result stp_select_request_meshes(stp_selection* s, const stp_select_entry* at,
                                                  bool replaced, double to, bool* here);
/// Whether the levels of its node stand for a part.
bool stp_select_replaces_part(const stp_selection* s, stp_store_part part);
/// Fills level_floors and level_overhangs.
void stp_select_find_levels(const stp_selection* s, stp_select_graph* graph);

// Triangles of levels by allowed error (level_counts.c).

/// Length of the diagonal of a node's box; 0: it is empty.
double stp_select_node_diagonal(const stp_store_node* node);
/// Error of levels of triangles, in pixels, that is allowed at most beside splats of a size in
/// pixels.
double stp_select_level_error(double splat_size);
/// The same for a node that has levels: less where that adds few triangles for what they cover.
double stp_select_node_level_error(const stp_selection* s, const stp_select_entry* at,
                                   const stp_box_visibility* sight);
/// Fills level_rows, level_counts and level_areas. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_select_count_levels(const stp_selection* s, stp_select_graph* graph);

/// Fills opens_below, once level_floors and level_counts are known. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_select_find_level_works(const stp_selection* s,
                                                    stp_select_graph* graph);

/// Whether there are only points below a node. Sets of `blue` and `stochastic` then have original
/// points as splats.
bool stp_select_is_of_points(const stp_selection* s, uint32_t node);

/// An item of the first `use->count` splats of a set.
stp_draw_item stp_select_splat_item(const stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use);

/// Appends an item with this many ids, and sets its first_id.
STP_MUST_USE stp_result stp_select_add_item(stp_selection* s, stp_draw_item item,
                                            uint64_t id_count);
/// The coverage radius down to which a node's own set is used, where splats of a size are wanted.
double stp_select_reach(const stp_selection* s, uint32_t node, double splat_size);
/// Appends a run of the next item: splats [begin, end) are drawn between two depths.
STP_MUST_USE stp_result stp_select_add_run(stp_selection* s, uint32_t begin, uint32_t end,
                                           stp_depth_range range);

/// Makes an item draw the state with `wanted` splats of a progressive set, or the nearest state in
/// the item's prefix. If the base set has more than `wanted`, draws its first `wanted` splats. Sets
/// the item's prefix to the state's. @return STP_OK, or as stp_store_get_splat_set_prefix; `*found`:
/// whether the set has states; if not, the item is unchanged
STP_MUST_USE stp_result stp_select_cut_item(stp_selection* s, uint32_t wanted, stp_draw_item* item,
                                            bool* found);

/// Number of splats that can be drawn at once from the set of a node, which has one. @return
/// STP_OK, or as stp_store_get_splat_set_prefix
STP_MUST_USE stp_result stp_select_max_count(stp_selection* s, uint32_t node, uint32_t* maximum);

/// Share of a node's content that is drawn at a depth, given the depth beyond which the node's set
/// suffices.
double stp_level_switch_share(double switch_depth, double depth);

/// Builds, or finds, the view-independent properties of the store's nodes.
STP_MUST_USE stp_result stp_select_find_graph(stp_selection* s);
void stp_select_destroy_graph(stp_context* context, stp_select_graph* graph);

/// Counts a visited node. @return STP_OK or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_select_count_visit(stp_selection* s);
STP_MUST_USE stp_result stp_select_push(stp_selection* s, const stp_select_entry* entry);
/// Visits all pushed nodes.
STP_MUST_USE stp_result stp_select_traverse(stp_selection* s);

/// Whether the pyramid occludes a node. In the first pass, occluded nodes are deferred.
STP_MUST_USE stp_result stp_select_hide(stp_selection* s, const stp_select_entry* at,
                                        const stp_boxd* box, const stp_box_visibility* sight,
                                        bool* hidden);

// Distributes a splat count over sets.

/// Registers the set of a node, which has splats, for a share of the count.
STP_MUST_USE stp_result stp_select_note_set(stp_selection* s, const stp_select_entry* at);

/// Distributes the count over the registered sets, and appends their items.
STP_MUST_USE stp_result stp_select_add_count(stp_selection* s);
