// SPDX-License-Identifier: MIT
// Distributes a number of splats over the leaves of a set, for method `stochastic` with --splats.
#include "base/splats/leaf_runs.h"
#include "select/cues.h"

#include <assert.h>

#define OPENS_FROM 4 // a cube that gets fewer splats is opened only if each part gets one
#define UNSEEN 0.01  // weight of a leaf outside the view, for each splat of the view's size

/// What a node of the tree over the leaves gets.
typedef struct stp_cue_part {
    double weight;  ///< of a leaf
    double wanted;  ///< splats of its leaves at the density
    uint32_t given; ///< the same as a whole number, once its parent is opened
} stp_cue_part;

/// Distribution of a splat count over the leaves of a set.
typedef struct cue_share {
    const stp_cue_view* view;
    uint32_t octaves; ///< number of loaded octaves
    double density;   ///< splats per unit of weight
    stp_cue_part* parts;
} cue_share;

/// Weight of a leaf by the view; 0 of a cube, whose leaves share its ray if they are few.
static double importance_of(const stp_cue_view* view, uint32_t index, stp_cue_ray* ray)
{
    const stp_leaf_node* node = &view->leaves->nodes[index];
    stp_box_visibility sight;
    if (!stp_cue_is_in_view(view, node, &sight)) {
        return node->leaf_count > 1 ? 0.0 : UNSEEN * stp_cue_nominal(view, node, view->sight);
    }
    stp_cue_trace(ray, view, index, false, &sight);
    return node->leaf_count > 1 ? 0.0 : stp_cue_importance(view, node, &sight, ray->before);
}

/// Weight of a leaf by its area and the view-independent cues, or the area alone with
/// STP_CUE_ERROR_BIT.
static double area_of(const stp_cue_view* view, const stp_leaf_node* node)
{
    bool plain = (view->cues & STP_CUE_ERROR_BIT) != 0;
    return (double)node->area * (plain ? 1.0 : stp_cue_shape(view, node));
}

static void weigh(cue_share* share)
{
    const stp_store_leaves* leaves = share->view->leaves;
    bool by_view = (share->view->cues & STP_CUE_IMPORTANCE_BIT) != 0;
    stp_cue_ray ray = {0};
    for (uint32_t i = 0; i < leaves->node_count; ++i) {
        const stp_leaf_node* node = &leaves->nodes[i];
        share->parts[i].weight = by_view                ? importance_of(share->view, i, &ray)
                                 : node->leaf_count > 1 ? 0.0
                                                        : area_of(share->view, node);
    }
}

static uint32_t count_loaded(const cue_share* share, const stp_leaf_node* node)
{
    return stp_cue_count(share->view->set, node->first, node->first + node->count, share->octaves);
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
        double given = 0.0, weight = 0.0;
        for (uint32_t i = 0; i < leaves->node_count; ++i) {
            const stp_leaf_node* node = &leaves->nodes[i];
            if (node->leaf_count > 1) {
                continue;
            }
            double mine = share->parts[i].weight;
            double maximum = (double)count_loaded(share, node);
            bool all = share->density * mine >= maximum;
            given += all ? maximum : 0.0;
            weight += all ? 0.0 : mine;
        }
        double next = weight > 0.0 ? (wanted - given) / weight : share->density;
        grows = next > share->density;
        share->density = grows ? next : share->density;
    }
}

/// What each cube wants: the sum over its leaves.
static void sum_wanted(cue_share* share)
{
    const stp_store_leaves* leaves = share->view->leaves;
    for (uint32_t i = leaves->node_count; i-- > 0;) { // parts before their cube
        const stp_leaf_node* node = &leaves->nodes[i];
        double sum =
            fmin(share->density * share->parts[i].weight, (double)count_loaded(share, node));
        if (node->leaf_count > 1) {
            sum = 0.0;
            for (uint32_t k = i + 1; k < node->next; k = leaves->nodes[k].next) {
                sum += share->parts[k].wanted;
            }
        }
        share->parts[i].wanted = sum;
    }
}

/// Gives each part of a cube its whole number of splats; together they have those of the cube.
/// @return the number of parts with a surface that get none
static uint32_t share_among_parts(cue_share* share, uint32_t index)
{
    const stp_leaf_node* nodes = share->view->leaves->nodes;
    uint32_t end = nodes[index].next, left = share->parts[index].given, bare = 0;
    double per = share->parts[index].wanted > 0.0 ? (double)left / share->parts[index].wanted : 0.0;
    double carried = 0.0;
    for (uint32_t i = index + 1; i < end; i = nodes[i].next) {
        uint32_t maximum = count_loaded(share, &nodes[i]);
        carried += per * share->parts[i].wanted;
        double whole = fmin(fmax(floor(carried + 0.5), 0.0), fmin(maximum, left));
        share->parts[i].given = (uint32_t)whole;
        carried -= whole;
        left -= share->parts[i].given;
    }
    for (uint32_t i = index + 1; i < end; i = nodes[i].next) { // remainder of rounding
        uint32_t room = count_loaded(share, &nodes[i]) - share->parts[i].given;
        uint32_t more = room < left ? room : left;
        share->parts[i].given += more;
        left -= more;
        bare += share->parts[i].given == 0 && nodes[i].area > 0.0f ? 1 : 0;
    }
    assert(left == 0 && "a cube gets no more than its leaves have");
    return bare;
}

/// Goes down the tree as long as every part gets splats, or many do.
static stp_result add_cells(stp_selection* s, cue_share* share, size_t* count)
{
    const stp_store_leaves* leaves = share->view->leaves;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < leaves->node_count && result == STP_OK;) {
        const stp_leaf_node* node = &leaves->nodes[i];
        uint32_t given = share->parts[i].given;
        bool opens = node->leaf_count > 1 && given > 0 &&
                     (share_among_parts(share, i) == 0 || given >= OPENS_FROM);
        if (!opens) {
            result = stp_cue_add_cell(s, count, stp_cue_cell_make(node, given));
        }
        i = opens ? i + 1 : node->next;
    }
    return result;
}

stp_result stp_cue_share_out(stp_selection* s, const stp_cue_view* view, uint32_t wanted,
                             uint32_t here, size_t* count)
{
    assert(wanted <= view->set->count && here <= view->set->count);
    if (wanted == view->set->count && here == wanted) {
        return stp_cue_add_cell(s, count, (stp_cue_cell){.last = wanted, .count = wanted});
    }
    stp_draw_list* list = s->list;
    if (!STP_MAKE_ROOM(s->context, list->parts, list->part_capacity, view->leaves->node_count)) {
        return stp_fail_memory(s->context);
    }
    cue_share share = {
        .view = view, .octaves = stp_cue_octaves(view->set, here), .parts = list->parts};
    weigh(&share);
    find_density(&share, (double)wanted);
    sum_wanted(&share);
    share.parts[0].given = wanted;
    return add_cells(s, &share, count);
}
