// SPDX-License-Identifier: MIT
// Method `stochastic`, sets built leaf by leaf. The cues decide how many splats a view takes from
// each leaf. These are the first of the leaf's order, so they stay the same while the eye rests
// (Bhakar, Luo, Mudur 2004, 3.2). Distant content is taken by whole octree cubes. If all splats of
// a set do not suffice, the node is opened.
#include "base/splats/prefix_table.h"
#include "select/cues.h"
#include "select/rule.h"

#include <assert.h>

// Limits of a cube that is not opened: splats for each of its leaves and in all, and its farthest
// depth over its nearest.
#define CELL_SAMPLES 0.5
#define CELL_LARGEST 16.0
#define CELL_DEPTHS 1.25
#define CUES_MAX 8.0 // factor on nominal samples: a bent region with an edge or a silhouette

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

/// Takes exactly `count` splats, which may all be of a few leaves.
static void choose_count(stp_set_use* use, uint32_t count)
{
    use->state = count < use->splats->count ? count : use->splats->count;
    use->count = use->splats->count;
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

/// A number in (0, 1) that differs from cube to cube and is the same in every view; those of
/// neighbours along the curve are far apart.
static double threshold_of(const stp_leaf_node* node)
{
    uint32_t golden = (node->leaf + 1u) * 2654435769u; // 2^32 over the golden ratio
    return ((double)golden + 0.5) * 0x1p-32;
}

/// Splats of a cube of several leaves that is not opened. Only whole octaves are spread evenly over
/// its leaves. The threshold of each cube decides between two of them, so that many cubes together
/// draw what they want, and none changes its mind twice as the eye comes closer.
static uint32_t count_of_cube(const stp_splats* set, const stp_leaf_node* node, double samples,
                              uint32_t here)
{
    uint32_t octaves = stp_cue_octaves(set, here), low = 0, high = 0;
    for (uint32_t k = 1; k <= octaves && (double)high <= samples; ++k) {
        low = high;
        high = stp_cue_count(set, node->first, node->first + node->count, k);
    }
    low = samples < (double)high ? low : high;
    double over = samples - (double)low, threshold = threshold_of(node);
    if (low == 0) { // few splats of the first octave that has any
        uint32_t few = (uint32_t)(samples + threshold);
        few = samples >= 1.0 && few == 0 ? 1 : few;
        return few < high ? few : high;
    }
    return over > threshold * (double)(high - low) ? high : low;
}

/// Chooses the splats of a cube or leaf for a number of samples.
static stp_cue_cell cell_of(const stp_splats* set, const stp_leaf_node* node, double samples,
                            uint32_t here)
{
    assert(node->count > 0);
    if (node->leaf_count > 1) {
        return stp_cue_cell_make(node, count_of_cube(set, node, samples, here));
    }
    uint32_t octaves = stp_cue_octaves(set, here);
    uint32_t maximum = stp_cue_count(set, node->first, node->first + node->count, octaves);
    uint32_t count = samples < (double)maximum ? (uint32_t)(samples + 0.5) : maximum;
    assert(count <= maximum && maximum <= node->count);
    return stp_cue_cell_make(node, count);
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
    uint32_t octaves = stp_cue_octaves(set, here);
    uint32_t maximum = stp_cue_count(set, node->first, node->first + node->count, octaves);
    return stp_cue_cell_make(node, maximum > 0 ? 1 : 0);
}

/// State of a visit to the cubes of a set.
typedef struct cue_walk {
    double carried;       ///< rounding error so far
    stp_cue_ray ray;      ///< the last one
    stp_cue_cell minimum; ///< one splat of a visible cube
} cue_walk;

/// Whether the cues of a cube are found part by part.
static bool is_opened(const stp_cue_view* view, const stp_leaf_node* node,
                      const stp_box_visibility* sight)
{
    if (node->leaf_count == 1) {
        return false;
    }
    double nominal = stp_cue_nominal(view, node, sight);
    bool deep = !view->flat_view && sight->range.far > CELL_DEPTHS * sight->range.near;
    return nominal > fmin(CELL_SAMPLES * (double)node->leaf_count, CELL_LARGEST) ||
           (deep && nominal > 1.0);
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
        if (!stp_cue_is_in_view(view, node, &sight)) {
            i = node->next;
            continue;
        }
        bool opens = is_opened(view, node, &sight);
        stp_cue_trace(&walk.ray, view, i, !opens, &sight);
        if (!opens) {
            double samples = stp_cue_samples(view, node, &sight, walk.ray.before);
            samples = node->leaf_count == 1 ? round_leaf(node, samples, &walk.carried) : samples;
            assert(!(samples < 0.0));
            result = stp_cue_add_cell(s, count, cell_of(view->set, node, samples, here));
            walk.minimum =
                walk.minimum.count == 0 ? single_splat(view->set, node, here) : walk.minimum;
        }
        i = opens ? i + 1 : node->next;
    }
    return result == STP_OK && *count == 0 ? stp_cue_add_cell(s, count, walk.minimum) : result;
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
        result = use->state > 0 ? stp_cue_share_out(s, &view, use->state, use->count, &count)
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
