// SPDX-License-Identifier: MIT
// Method `stochastic`, sets built leaf by leaf. The cues decide how many splats a view takes from
// each leaf. These are the first of the leaf's order, so they stay the same while the eye rests
// (Bhakar, Luo, Mudur 2004, 3.2). Distant content is taken by whole octree cubes. If all splats of
// a set do not suffice, the node is opened.
#include "base/splats/leaf_runs.h"
#include "base/splats/prefix_table.h"
#include "select/cues.h"
#include "select/rule.h"

#include <assert.h>

#define CELL_SAMPLES 0.5 // maximum splats per leaf of a cube that is not opened
#define CUES_MAX 8.0     // factor on nominal samples: a bent region with an edge or a silhouette

enum {
    /// Cubes of at most this many leaves share one ray (docs/notes/2026-11-stochastic-speed.md).
    RAY_LEAVES = 32
};

/// Number of splats in the fewest octaves that hold at least `count`.
static uint32_t round_count(const stp_splats* set, double count)
{
    for (uint32_t k = 0; k < set->octave_count; ++k) {
        if ((double)set->octave_ends[k] >= count) {
            return set->octave_ends[k];
        }
    }
    return set->count;
}

static double reach_of(const stp_splats* set, uint32_t count)
{
    return (double)stp_prefix_table_radius(&set->table, count);
}

/// Octaves that leaves at depth `nearest` and beyond may need.
static void choose_from(double nearest, stp_set_use* use)
{
    double wanted = use->per_depth * nearest, all = reach_of(use->splats, use->splats->count);
    double share = wanted > all ? all / wanted : 1.0;
    use->count = round_count(use->splats, CUES_MAX * share * share * (double)use->splats->count);
    use->radius = fmax(wanted, all);
}

static void choose(const stp_selection* s, const stp_select_entry* at,
                   const stp_box_visibility* sight, bool cloud, stp_set_use* use)
{
    double nearest;
    if (stp_select_find_nearest(s, at, sight, cloud, use, &nearest)) {
        choose_from(nearest, use);
    }
}

/// Takes exactly `count` splats of all leaves, visible or not.
static void choose_count(stp_set_use* use, uint32_t count)
{
    use->state = count < use->splats->count ? count : use->splats->count;
    use->count = round_count(use->splats, (double)use->state * CUES_MAX);
    use->radius = reach_of(use->splats, count);
}

static void limit(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use)
{
    (void)at;
    if (use->per_depth > 0.0 && use->state == 0) {
        choose_from(nearest, use);
    }
    if (use->count > here || use->count == 0) {
        use->count = here;
        use->radius = fmax(use->radius, reach_of(use->splats, here));
    }
    use->state = use->state < here ? use->state : here;
    assert(use->state <= use->splats->count);
}

static stp_result add_cell(stp_selection* s, size_t* count, stp_cue_cell cell)
{
    stp_draw_list* list = s->list;
    if (cell.count == 0) {
        return STP_OK;
    }
    if (*count == list->cell_capacity) {
        if (!STP_MAKE_ROOM(s->context, list->cells, list->cell_capacity, *count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    list->cells[(*count)++] = cell;
    return STP_OK;
}

/// Chooses the splats of a cube for a number of samples: whole octaves for several leaves, the
/// exact number for one.
static stp_cue_cell cell_of(const stp_splats* set, const stp_leaf_node* node, double samples,
                            uint32_t here)
{
    assert(node->count > 0);
    stp_cue_cell cell = {.first = node->first, .last = node->first + node->count};
    double share = samples / (double)node->count;
    uint32_t octaves =
        node->leaf_count > 1 ? stp_cue_octaves(set, share, here) : stp_cue_octaves(set, 1.0, here);
    uint32_t maximum = stp_cue_count(set, cell.first, cell.last, octaves);
    uint32_t wanted = samples < (double)maximum ? (uint32_t)(samples + 0.5) : maximum;
    assert(wanted <= maximum && maximum <= node->count);
    cell.count = node->leaf_count > 1 ? maximum : wanted;
    return cell;
}

/// Rounds the samples of a leaf. The rounding error goes to the next leaf along the curve.
static double round_leaf(const stp_leaf_node* node, double samples, double* carried)
{
    double all = (double)node->count;
    *carried += fmin(samples, all);
    double whole = fmin(floor(*carried + 0.5), all);
    *carried -= whole;
    assert(fabs(*carried) < 1.0 && "rounding errors do not add up");
    return whole;
}

/// One splat of a cube, if the loaded octaves contain one.
static stp_cue_cell single_splat(const stp_splats* set, const stp_leaf_node* node, uint32_t here)
{
    stp_cue_cell cell = {.first = node->first, .last = node->first + node->count};
    uint32_t maximum = stp_cue_count(set, cell.first, cell.last, stp_cue_octaves(set, 1.0, here));
    cell.count = maximum > 0 ? 1 : 0;
    return cell;
}

/// State of a visit to the cubes of a set.
typedef struct cue_walk {
    double carried;       ///< rounding error so far
    double before;        ///< splats between the eye and the cube of the last ray
    uint32_t ray_until;   ///< first node outside that cube
    stp_cue_cell minimum; ///< one splat of a visible cube
} cue_walk;

/// Whether any splat of a cube may be in view. Splats extend beyond the cube, and all its points
/// may lie on the face next to the picture.
static bool is_cube_in_view(const stp_selection* s, const stp_cue_view* view,
                            const stp_leaf_node* node, stp_box_visibility* sight)
{
    stp_boxd box = stp_cue_box(view, node);
    if (stp_select_is_in_view(s, &box, sight)) {
        return true;
    }
    double reach = stp_cue_overhang(view, node, &box);
    stp_vec3d margin = {reach, reach, reach};
    box = (stp_boxd){stp_subd(box.min, margin), stp_addd(box.max, margin)};
    return stp_select_is_in_view(s, &box, sight);
}

/// Traces a ray to the eye from a cube that is not opened, or from one of few leaves, which share
/// it.
static void trace_to_eye(cue_walk* walk, const stp_cue_view* view, uint32_t index, bool opens,
                         const stp_box_visibility* sight)
{
    const stp_leaf_node* node = &view->leaves->nodes[index];
    if (index >= walk->ray_until && (!opens || node->leaf_count <= RAY_LEAVES)) {
        walk->before = stp_cue_before(view, node, stp_cue_occlusion_limit(view, node, sight));
        walk->ray_until = node->next;
    }
}

/// Visits visible cubes, and opens those that need many splats. A visible set draws at least one
/// splat, even if all its points coincide.
static stp_result choose_cells(stp_selection* s, const stp_cue_view* view, uint32_t here,
                               size_t* count)
{
    const stp_leaf_node* nodes = view->leaves->nodes;
    stp_result result = STP_OK;
    cue_walk walk = {0};
    for (uint32_t i = 0; i < view->leaves->node_count && result == STP_OK;) {
        const stp_leaf_node* node = &nodes[i];
        assert(node->next > i && node->next <= view->leaves->node_count);
        stp_box_visibility sight;
        if (!is_cube_in_view(s, view, node, &sight)) {
            i = node->next;
            continue;
        }
        bool opens = node->leaf_count > 1 &&
                     stp_cue_nominal(view, node, &sight) > CELL_SAMPLES * (double)node->leaf_count;
        trace_to_eye(&walk, view, i, opens, &sight);
        if (!opens) {
            double samples = stp_cue_samples(view, node, &sight, walk.before);
            samples = node->leaf_count == 1 ? round_leaf(node, samples, &walk.carried) : samples;
            assert(!(samples < 0.0));
            result = add_cell(s, count, cell_of(view->set, node, samples, here));
            walk.minimum =
                walk.minimum.count == 0 ? single_splat(view->set, node, here) : walk.minimum;
        }
        i = opens ? i + 1 : node->next;
    }
    return result == STP_OK && *count == 0 ? add_cell(s, count, walk.minimum) : result;
}

/// Weight of a leaf when a splat count is distributed: the view-independent cues, or the area alone
/// with STP_CUE_ERROR_BIT.
static double worth_of(const stp_cue_view* view, const stp_leaf_node* node)
{
    double samples = (double)node->area;
    if ((view->cues & STP_CUE_ERROR_BIT) != 0) {
        return samples;
    }
    bool edge = node->edge && (view->cues & STP_CUE_EDGE_BIT) != 0;
    samples *= edge ? STP_CUE_FEATURE : 1.0;
    bool bends = (view->cues & STP_CUE_FLATNESS_BIT) != 0;
    return samples * (bends ? 1.0 + fmin((double)node->flatness / STP_CUE_FLATNESS, 1.0) : 1.0);
}

/// Distribution of a splat count over the leaves of a set.
typedef struct cue_share {
    const stp_cue_view* view;
    uint32_t octaves; ///< number of loaded octaves
    double density;   ///< splats per unit of weight
} cue_share;

static uint32_t find_max_worth(const cue_share* share, uint32_t first, uint32_t count)
{
    return stp_cue_count(share->view->set, first, first + count, share->octaves);
}

/// Finds the splats per unit of weight so that all leaves together have `wanted`. Leaves with too
/// few splats give all; the others share the difference, repeatedly.
static void find_density(cue_share* share, double wanted)
{
    enum { ROUNDS_MAX = 64 };
    const stp_store_leaves* leaves = share->view->leaves;
    bool grows = true;
    share->density = 0.0;
    for (int round = 0; round < ROUNDS_MAX && grows; ++round) {
        double given = 0.0, worth = 0.0;
        for (uint32_t i = 0; i < leaves->node_count; ++i) {
            const stp_leaf_node* node = &leaves->nodes[i];
            if (node->leaf_count > 1) {
                continue;
            }
            double mine = worth_of(share->view, node);
            double maximum = (double)find_max_worth(share, node->first, node->count);
            bool all = share->density * mine >= maximum;
            given += all ? maximum : 0.0;
            worth += all ? 0.0 : mine;
        }
        double next = worth > 0.0 ? (wanted - given) / worth : share->density;
        grows = next > share->density;
        share->density = grows ? next : share->density;
    }
}

/// Distributes `wanted` splats over all leaves by weight, limited by their counts. The first leaves
/// with spare splats take the remainder of rounding.
static stp_result share_out(stp_selection* s, const stp_cue_view* view, uint32_t wanted,
                            uint32_t here, size_t* count)
{
    assert(wanted <= view->set->count && here <= view->set->count);
    if (wanted == view->set->count && here == wanted) {
        return add_cell(s, count, (stp_cue_cell){0, wanted, wanted, 0, 0});
    }
    cue_share share = {.view = view, .octaves = stp_cue_octaves(view->set, 1.0, here)};
    find_density(&share, (double)wanted);
    double carried = 0.0;
    uint32_t left = wanted;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < view->leaves->node_count && result == STP_OK; ++i) {
        const stp_leaf_node* node = &view->leaves->nodes[i];
        if (node->leaf_count > 1) {
            continue;
        }
        double maximum = (double)find_max_worth(&share, node->first, node->count);
        carried += fmin(share.density * worth_of(view, node), maximum);
        double whole = fmin(fmin(floor(carried + 0.5), maximum), (double)left);
        uint32_t drawn = whole > 0.0 ? (uint32_t)whole : 0;
        carried -= (double)drawn;
        left -= drawn;
        result =
            add_cell(s, count, (stp_cue_cell){node->first, node->first + node->count, drawn, 0, 0});
    }
    for (size_t i = 0; i < *count && left > 0; ++i) { // remainder of rounding
        stp_cue_cell* cell = &s->list->cells[i];
        assert(cell->count <= find_max_worth(&share, cell->first, cell->last - cell->first));
        uint32_t more = find_max_worth(&share, cell->first, cell->last - cell->first) - cell->count;
        more = more < left ? more : left;
        cell->count += more;
        left -= more;
    }
    return result;
}

static stp_draw_item make_item(const stp_selection* s, const stp_select_entry* at,
                               const stp_set_use* use)
{
    stp_draw_item item = stp_select_splat_item(s, at, use);
    item.of_points = stp_select_is_of_points(s, at->node);
    return item;
}

/// Without leaves, a prefix of the set is a random sample, with splats large enough for it.
static stp_result add_plain(stp_selection* s, const stp_set_use* use, stp_draw_item item,
                            stp_depth_range drawn)
{
    uint32_t prefix = use->state > 0 ? use->state : use->count;
    assert(prefix > 0 && prefix <= use->splats->count);
    item.prefix = item.full_prefix = prefix;
    item.shape_scale = (float)sqrt((double)use->splats->count / (double)prefix);
    if (drawn.near > 0.0 || drawn.far < HUGE_VAL) {
        size_t first = s->list->run_count;
        stp_result result = stp_select_add_run(s, 0, prefix, drawn);
        if (result != STP_OK) {
            return result;
        }
        item.first_run = (uint32_t)first;
        item.run_count = 1;
    }
    return stp_select_add_item(s, item, item.prefix);
}

static stp_result add(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_box_visibility* sight)
{
    stp_store_leaves leaves = {0};
    stp_select_request_leaves(s, at, sight, use->set);
    stp_result result = stp_store_get_leaves(s->store, use->set, &leaves);
    if (result != STP_OK) {
        return result;
    }
    stp_draw_item item = make_item(s, at, use);
    stp_depth_range drawn = {use->in_level_switch ? use->switch_depth : 0.0,
                             at->ancestor_switch_depth < HUGE_VAL
                                 ? at->ancestor_switch_depth * STP_LEVEL_SWITCH_FAR
                                 : HUGE_VAL};
    drawn.near = drawn.near <= sight->range.near ? 0.0 : drawn.near;
    drawn.far = drawn.far >= sight->range.far ? HUGE_VAL : drawn.far;
    uint64_t before = s->list->splat_count;
    if (leaves.leaf_count == 0) {
        result = add_plain(s, use, item, drawn);
    } else {
        stp_cue_view view = stp_cue_view_make(s, at, use->splats, &leaves, sight);
        size_t count = 0;
        result = use->state > 0 ? share_out(s, &view, use->state, use->count, &count)
                                : choose_cells(s, &view, use->count, &count);
        result = result == STP_OK
                     ? stp_cue_add_items(s, use->splats, s->list->cells, count, item, drawn)
                     : result;
    }
    s->list->extra_splats +=
        at->in_level_switch || use->in_level_switch ? s->list->splat_count - before : 0;
    return result;
}

const stp_select_rule stp_select_rule_cues = {choose, choose_count, limit, add};
