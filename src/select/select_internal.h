// SPDX-License-Identifier: MIT
// What the parts of selection share: the state of a call, and what is decided of a node.
#pragma once

#include "select/sections.h"
#include "select/select.h"

/// Times the depth at which a node's surfels just suffice: up to there what is below it grows in.
#define STP_LEVELS_GROW 1.1
/// What a set may lack of the wanted radius before all of its surfels are gone.
#define STP_LEVELS_LACK 1.07
#define STP_LEVELS_LACK_TWICE (STP_LEVELS_LACK * STP_LEVELS_LACK)
/// The same in depths: where they just suffice is moved out by the third power, at least, of what they lack (prefix.c).
#define STP_LEVELS_SHRINK (STP_LEVELS_LACK_TWICE * STP_LEVELS_LACK_TWICE)

/// Cost of a splat in those of a triangle (docs/notes/2026-11-proportion.md).
#define STP_SPLAT_WORK 1.5
/// Most work of a node in transition, in that of the dearer of its two ways.
#define STP_TRANSITION_WORK 1.2

/// Most and default stp_quality.spare.
#define STP_SPARE_MOST 8.0

static inline double stp_select_spare(const stp_quality* quality)
{
    double spare = (double)quality->spare;
    return !(spare > 0.0) ? STP_SPARE_MOST : fmin(fmax(spare, 1.0), STP_SPARE_MOST);
}

/// A node still to be looked at.
typedef struct stp_select_entry {
    uint32_t node;
    bool moving_only;  ///< an ancestor's surfels stand for all that does not move
    bool extra;        ///< an ancestor is drawn where it is nearest
    uint32_t sections; ///< bits of planes that may cut it
    uint32_t shown;    ///< of the visibility
    double ceiling;    ///< beyond this depth an ancestor's surfels suffice
    double
        covered;  ///< how well the nearest ancestor's set covers, scene units; infinite: none does
    double eager; ///< how much sooner what is below is loaded than what it covers with tells
    stp_affine transform;
} stp_select_entry;

/// What is known of a store's nodes, once for all views. Children come before their parents.
typedef struct stp_select_graph {
    const stp_store_directory* directory;
    const stp_store_node* nodes;
    uint32_t node_count, edge_count, part_count, surfels_count;
    uint32_t method; ///< of the sets
    uint8_t* moving; ///< STP_NODE_MOVES, STP_MOVES_BELOW
    float*
        margins; ///< how far what is drawn of a node may stick out of its box, beside pixels; node units
    double* reaches;   ///< coverage radius of all surfels of its own, node units
    float* spares;     ///< times that, down to which they are used at the most
    float* works;      ///< most work of what is drawn instead of them, in triangles
    uint8_t* repeated; ///< of each part: whether its node lists it before, too; a bit each
    bool* has_sets;    ///< it or a node below it has a set
    uint32_t* most;    ///< splats that its set can be drawn with; 0: not known yet
} stp_select_graph;

enum { STP_NODE_MOVES = 1, STP_MOVES_BELOW = 2 };

typedef struct stp_selection {
    stp_context* context;
    stp_store* store; ///< read, unless a set's columns are needed (cuts.c)
    const stp_store_directory* directory;
    const stp_quality* quality;
    const stp_sections* sections;
    stp_draw_list* list;
    uint32_t method; ///< its place in the directory's table
    const struct stp_select_rule* rule;
    uint32_t
        coarse_method; ///< the same of sets that stand for large shares of others; STP_STORE_NONE: none
    const stp_select_graph* graph;
    stp_view_frame frames[STP_EYES_MOST]; ///< of each eye, with one gaze, scale and near plane
    uint32_t eye_count;
    size_t stack_count;
    uint64_t visits;
    size_t cut_count;   ///< of states, in this call
    size_t share_count; ///< of a count of splats
    bool second_pass;
    bool streams; ///< what is resident is drawn, and what would be is asked for
} stp_selection;

/// Depths between which a box is seen; both 1 in parallel projection.
typedef struct stp_depth_range {
    double near, far;
} stp_depth_range;

/// What is seen of a box.
typedef struct stp_sight {
    stp_depth_range range; ///< for the eyes that see it together
    uint32_t eyes;         ///< bits of those that may see it
    bool is_inside;        ///< one is within
    double splat_size;     ///< pixels: the least wanted of what is seen
    double largest_size;   ///< the largest of all that is seen, at least that where an eye looks
} stp_sight;

/// How a node's surfels are used. They are drawn beyond switch_depth, what is below the node is drawn nearer.
typedef struct stp_set_use {
    const struct stp_select_rule* rule;
    uint32_t set; ///< of the store
    const stp_splats* surfels;
    uint32_t count; ///< prefix; 0: not drawn
    uint32_t state; ///< splats of the state of a progressive set that is drawn; 0: by levels
    double radius;  ///< of its splats, node units
    double level_per_depth, level_least; ///< of the item
    double per_depth;    ///< the wanted coverage radius at depth 1, node units; 0: not by depth
    double switch_depth; ///< 0: nothing below is drawn; infinite: all of it
    bool extra;          ///< switching would not draw them
} stp_set_use;

/// The set of a node by the method that is drawn.
static inline uint32_t stp_select_set_of(const stp_selection* s, uint32_t node)
{
    return stp_store_set_of(s->directory, s->method, node);
}

/// @return whether any eye may see some of the box
bool stp_select_see(const stp_selection* s, const stp_boxd* box, stp_sight* sight);

/// The box that holds a transformed box.
stp_boxd stp_select_place_box(const stp_affine* transform, const stp_boxd* box);
/// The box of a node's mesh or points, in scene space.
stp_boxd stp_select_part_box(const stp_selection* s, stp_store_part part,
                             const stp_affine* transform);

// Of stores that stream (resident.c).
/// Empties the list's wants, but in the second pass.
STP_MUST_USE stp_result stp_select_begin_wants(stp_selection* s);
/// Asks for what a use needs of a set that can be done without. @return whether it is here
bool stp_select_want_coarse(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                            const stp_set_use* use);
/// Asks for a mesh or points of a node. @return whether they are here
bool stp_select_want_part(stp_selection* s, stp_store_part part, const stp_select_entry* at,
                          const stp_sight* sight);
/// Asks for the leaves of a node's set. What is there of them, stp_store_get_leaves tells.
void stp_select_want_leaves(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                            uint32_t set);
/// Asks for a mesh that only makes better what is there without it: after all else. @return whether it is here
bool stp_select_want_extra(stp_selection* s, uint32_t mesh);
/// Makes the entry of a node with a set that of what is below it.
void stp_select_cover(const stp_selection* s, const stp_splats* surfels, const stp_sight* sight,
                      stp_select_entry* at);
/// Changes what is to be done with a node's surfels to what can be, and asks for what is missing.
STP_MUST_USE stp_result stp_select_limit_use(stp_selection* s, const stp_select_entry* at,
                                             const stp_sight* sight, stp_set_use* use);

/// Whether a set holds all points of a node without triangles: such a node is never opened, since points have no size of their
/// own. A cloud with points in one place is not complete: its set has one of them.
bool stp_select_is_complete(const stp_store_node* node, const stp_splats* surfels);

/// Whether there are only points below a node. Sets of `blue` and `stochastic` then have original points as splats.
bool stp_select_is_of_points(const stp_selection* s, uint32_t node);

/// Appends an item of so many ids, with its first_id.
STP_MUST_USE stp_result stp_select_add_item(stp_selection* s, stp_draw_item item,
                                            uint64_t id_count);
/// The coverage radius down to which a node's own set is used.
double stp_select_reach(const stp_selection* s, uint32_t node);
/// The wanted coverage radius at depth 1, in a node's units; 0 where there is none.
double stp_select_radius_per_depth(const stp_selection* s, const stp_select_entry* at,
                                   const stp_sight* sight);
/// Appends a run of an item that is to be added: splats [begin, end) are drawn between two depths.
STP_MUST_USE stp_result stp_select_add_run(stp_selection* s, uint32_t begin, uint32_t end,
                                           stp_depth_range range);

/// Makes an item draw the state with `wanted` splats of a progressive set, or the nearest that the item's prefix has. With fewer
/// than the base set has, the first of these. The item's prefix becomes that of the state. @return STP_OK, or as
/// stp_store_get_surfels_prefix; `*found`: whether the set has states; else the item stays as it is
STP_MUST_USE stp_result stp_select_cut_item(stp_selection* s, uint32_t wanted, stp_draw_item* item,
                                            bool* found);

/// The splats that the set of a node, which has some, can be drawn with at once. @return STP_OK, or as
/// stp_store_get_surfels_prefix
STP_MUST_USE stp_result stp_select_count_most(stp_selection* s, uint32_t node, uint32_t* most);

/// How much of what lies below a node is there at a depth, by the depth beyond which the node suffices.
double stp_select_growth(double ceiling, double depth);

/// Makes or finds what is known of the store's nodes.
STP_MUST_USE stp_result stp_select_find_graph(stp_selection* s);
void stp_select_destroy_graph(stp_context* context, stp_select_graph* graph);

/// Counts a node that is looked at. @return STP_OK or STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_select_count_visit(stp_selection* s);
STP_MUST_USE stp_result stp_select_push(stp_selection* s, const stp_select_entry* entry);
/// Looks at all that was pushed.
STP_MUST_USE stp_result stp_select_traverse(stp_selection* s);

/// Whether the pyramid hides a node. Where it does in the first pass, the node is set aside.
STP_MUST_USE stp_result stp_select_hide(stp_selection* s, const stp_select_entry* at,
                                        const stp_boxd* box, const stp_sight* sight, bool* hidden);
