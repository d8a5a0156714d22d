// SPDX-License-Identifier: MIT
#include "lod/stochastic/turn_subtrees.h"

#include <string.h>

enum { PASSES = 8 };

/// A link between two patches that meet in the tree.
typedef struct tree_link {
    uint32_t a, b;
    uint32_t top; ///< the lowest patch that is above both; UINT32_MAX: they are of different trees
    float agreement;
} tree_link;

typedef struct turner {
    const stp_patch_tree* tree;
    tree_link* links;
    size_t link_count;
    bool *turned, *turning, *settled;
    double* sums; ///< of each subtree: how much its links to the rest agree
} turner;

static uint32_t find_top(const stp_patch_tree* t, uint32_t a, uint32_t b)
{
    while (a != b) {
        uint32_t* lower = t->depths[a] < t->depths[b] ? &b : &a;
        if (t->parents[*lower] == *lower) {
            return UINT32_MAX;
        }
        *lower = t->parents[*lower];
    }
    return a;
}

static void list_links(turner* t, const stp_patch_links* links)
{
    for (uint32_t a = 0; a < t->tree->count; ++a) {
        for (uint32_t k = links->begins[a]; k < links->begins[a + 1]; ++k) {
            const stp_patch_link* link = &links->all[k];
            if (a < link->to) {
                t->links[t->link_count++] =
                    (tree_link){a, link->to, find_top(t->tree, a, link->to), link->agreement};
            }
        }
    }
}

/// Sums up links between each subtree and the rest. @return the sum of all links
static double sum_up(turner* t)
{
    double all = 0.0;
    memset(t->sums, 0, t->tree->count * sizeof(*t->sums));
    for (size_t i = 0; i < t->link_count; ++i) {
        const tree_link* l = &t->links[i];
        double agreement =
            (double)(t->turned[l->a] == t->turned[l->b] ? l->agreement : -l->agreement);
        all += agreement;
        t->sums[l->a] += agreement;
        t->sums[l->b] += agreement;
        if (l->top != UINT32_MAX) { // above, both ends are inside
            t->sums[l->top] -= 2.0 * agreement;
        }
    }
    for (uint32_t at = t->tree->count; at-- > 0;) {
        uint32_t i = t->tree->sequence[at], parent = t->tree->parents[i];
        if (parent != i) {
            t->sums[parent] += t->sums[i];
        }
    }
    return all;
}

static void turn(turner* t)
{
    for (uint32_t i = 0; i < t->tree->count; ++i) {
        t->turned[i] = t->turned[i] != t->turning[i];
    }
}

/// Chooses subtrees that disagree with the rest, none in another. @return false: there is none
static bool choose(turner* t)
{
    bool any = false;
    uint32_t count = t->tree->count;
    memset(t->turning, 0, count);
    memset(t->settled, 0, count); // it has a chosen subtree
    for (uint32_t at = count; at-- > 0;) {
        uint32_t i = t->tree->sequence[at], parent = t->tree->parents[i];
        if (!t->settled[i] && t->sums[i] < 0.0 && parent != i) {
            t->turning[i] = t->settled[i] = any = true;
        }
        t->settled[parent] = t->settled[parent] || t->settled[i];
    }
    for (uint32_t at = 0; at < count; ++at) {
        uint32_t i = t->tree->sequence[at];
        t->turning[i] = t->turning[i] || t->turning[t->tree->parents[i]];
    }
    return any;
}

stp_result stp_turn_subtrees(stp_context* context, const stp_patch_links* links,
                             const stp_patch_tree* tree, bool* turned)
{
    turner t = {.tree = tree,
                .links = STP_NEW_ARRAY(context, tree_link, links->count / 2 + 1),
                .turned = turned,
                .turning = STP_NEW_ARRAY(context, bool, (size_t)tree->count + 1),
                .settled = STP_NEW_ARRAY(context, bool, (size_t)tree->count + 1),
                .sums = STP_NEW_ARRAY(context, double, (size_t)tree->count + 1)};
    bool has_room = t.links != NULL && t.turning != NULL && t.settled != NULL && t.sums != NULL;
    if (has_room) {
        list_links(&t, links);
        double best = sum_up(&t);
        for (int pass = 0; pass < PASSES && choose(&t); ++pass) {
            turn(&t);
            double all = sum_up(&t);
            if (!(all > best)) { // subtrees that are linked with each other
                turn(&t);
                break;
            }
            best = all;
        }
    }
    stp_free(context, t.sums);
    stp_free(context, t.settled);
    stp_free(context, t.turning);
    stp_free(context, t.links);
    return has_room ? STP_OK : stp_fail_memory(context);
}
