// SPDX-License-Identifier: MIT
#include "lod/stochastic/orient.h"

#include "base/leaf_codes.h"
#include "base/math.h"
#include "lod/stochastic/turn_subtrees.h"

#include <string.h>

enum {
    BRIDGE_PATCHES = 128, ///< of a piece, from which a way across a gap is looked for
    BRIDGES_MOST = 64,    ///< pieces for which one is looked for
};
#define GAP 4.0f // in sides of both leaves together

/// A step from a patch that is oriented to another: the least weight first, then the least patches.
typedef struct orient_step {
    float weight;
    uint32_t link, from;
} orient_step;

typedef struct orienter {
    const stp_leaf_octree* octree;
    const stp_patches* patches;
    stp_patch_links links;
    stp_patch_tree tree;
    uint32_t* pieces; ///< of each patch the first patch of its piece
    bool* turned;     ///< of each patch: its normal is on the other side
    bool* done;
    orient_step* heap;
    size_t heap_count;
} orienter;

static bool comes_before(const orient_step* a, const orient_step* b)
{
    if (a->weight < b->weight || a->weight > b->weight) {
        return a->weight < b->weight;
    }
    return a->link < b->link;
}

static void push(orienter* o, orient_step step)
{
    size_t at = o->heap_count++;
    while (at > 0 && comes_before(&step, &o->heap[(at - 1) / 2])) {
        o->heap[at] = o->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    o->heap[at] = step;
}

static orient_step pop(orienter* o)
{
    orient_step first = o->heap[0], last = o->heap[--o->heap_count];
    size_t at = 0, below = 1;
    while (below < o->heap_count) {
        if (below + 1 < o->heap_count && comes_before(&o->heap[below + 1], &o->heap[below])) {
            below += 1;
        }
        if (!comes_before(&o->heap[below], &last)) {
            break;
        }
        o->heap[at] = o->heap[below];
        at = below;
        below = 2 * at + 1;
    }
    o->heap[at] = last;
    return first;
}

static stp_vec3 normal_of(const orienter* o, uint32_t patch)
{
    return stp_scale(o->patches->all[patch].normal, o->turned[patch] ? -1.0f : 1.0f);
}

static void reach(orienter* o, uint32_t patch, uint32_t from)
{
    o->done[patch] = true;
    o->tree.parents[patch] = from;
    o->tree.depths[patch] = patch == from ? 0 : o->tree.depths[from] + 1;
    o->tree.sequence[o->tree.count++] = patch;
    for (uint32_t i = o->links.begins[patch]; i < o->links.begins[patch + 1]; ++i) {
        const stp_patch_link* link = &o->links.all[i];
        if (!o->done[link->to]) {
            push(o, (orient_step){link->weight, i, patch});
        }
    }
}

/// @param from the patch that it was reached from, or itself
static void spread_from(orienter* o, uint32_t patch, uint32_t from)
{
    reach(o, patch, from);
    while (o->heap_count > 0) {
        orient_step step = pop(o);
        const stp_patch_link* link = &o->links.all[step.link];
        if (!o->done[link->to]) {
            o->turned[link->to] = o->turned[step.from] != (link->agreement < 0.0f);
            reach(o, link->to, step.from);
        }
    }
}

/// Names the piece that each patch is of, with the heap's memory as a stack.
static void find_pieces(orienter* o)
{
    uint32_t* stack = (uint32_t*)(void*)o->heap;
    for (uint32_t i = 0; i < o->patches->count; ++i) {
        o->pieces[i] = UINT32_MAX;
    }
    for (uint32_t first = 0; first < o->patches->count; ++first) {
        size_t height = 0;
        if (o->pieces[first] == UINT32_MAX) {
            o->pieces[first] = first;
            stack[height++] = first;
        }
        while (height > 0) {
            uint32_t patch = stack[--height];
            for (uint32_t i = o->links.begins[patch]; i < o->links.begins[patch + 1]; ++i) {
                uint32_t to = o->links.all[i].to;
                if (o->pieces[to] == UINT32_MAX) {
                    o->pieces[to] = first;
                    stack[height++] = to;
                }
            }
        }
    }
}

static float width_of(const orienter* o, uint32_t patch)
{
    return (float)stp_leaf_width(o->octree->leaves[o->patches->all[patch].leaf].depth);
}

/// Of the patches of a piece about as high as the highest one, the one whose plane faces up most, less the farther below it is: a
/// leaf may be as wide as a box is high. At an edge or corner, what is up tells little.
static uint32_t find_highest(const orienter* o, uint32_t piece)
{
    const stp_patch* all = o->patches->all;
    uint32_t highest = piece, best = piece;
    float most = -HUGE_VALF;
    for (uint32_t i = piece; i < o->patches->count; ++i) {
        if (o->pieces[i] == piece && all[i].place.y > all[highest].place.y) {
            highest = i;
        }
    }
    float top = all[highest].place.y, width = width_of(o, highest);
    for (uint32_t i = piece; i < o->patches->count; ++i) {
        float below = (top - all[i].place.y) / width;
        float up = fabsf(all[i].normal.y) - all[i].doubt - below;
        if (o->pieces[i] == piece && below <= 1.0f && up > most) {
            most = up;
            best = i;
        }
    }
    return best;
}

/// The piece that is next to begin with: the highest one that is not oriented yet. UINT32_MAX: none is left.
static uint32_t find_highest_piece(const orienter* o)
{
    uint32_t highest = UINT32_MAX;
    for (uint32_t i = 0; i < o->patches->count; ++i) {
        bool is_higher =
            highest == UINT32_MAX || o->patches->all[i].place.y > o->patches->all[highest].place.y;
        if (!o->done[i] && is_higher) {
            highest = i;
        }
    }
    return highest != UINT32_MAX ? o->pieces[highest] : UINT32_MAX;
}

/// Looks for the shortest way from oriented patches to a piece. @return whether it is short enough
static bool find_bridge(const orienter* o, uint32_t piece, uint32_t* to, uint32_t* from)
{
    uint32_t size = 0, met = 0, count = o->patches->count;
    float least = HUGE_VALF;
    for (uint32_t i = 0; i < count; ++i) {
        size += o->pieces[i] == piece;
    }
    uint32_t stride = size / BRIDGE_PATCHES + 1;
    for (uint32_t i = 0; i < count; ++i) {
        if (o->pieces[i] != piece || met++ % stride != 0) {
            continue;
        }
        for (uint32_t k = 0; k < count; ++k) {
            stp_vec3 d = stp_sub(o->patches->all[i].place, o->patches->all[k].place);
            float squared = stp_dot(d, d);
            if (o->done[k] && squared < least) {
                least = squared;
                *to = i;
                *from = k;
            }
        }
    }
    return least < HUGE_VALF && sqrtf(least) <= GAP * (width_of(o, *to) + width_of(o, *from));
}

static stp_result orient_all(stp_context* context, orienter* o)
{
    find_pieces(o);
    uint32_t met = 0;
    for (uint32_t piece = find_highest_piece(o); piece != UINT32_MAX;
         piece = find_highest_piece(o)) {
        uint32_t to = 0, from = 0;
        bool across = met > 0 && met <= BRIDGES_MOST && find_bridge(o, piece, &to, &from);
        met += 1;
        if (across) {
            o->turned[to] = o->turned[from] != (stp_patch_agreement(&o->patches->all[from],
                                                                    &o->patches->all[to]) < 0.0f);
            spread_from(o, to, from);
        } else {
            uint32_t highest = find_highest(o, piece);
            o->turned[highest] = o->patches->all[highest].normal.y < 0.0f;
            spread_from(o, highest, highest);
        }
    }
    return stp_turn_subtrees(context, &o->links, &o->tree, o->turned);
}

/// Turns a tree of most patches whose volume is negative: that of a closed surface is the sum of heights times how
/// far its parts face up. Where sides or bottom are open, what faces up still counts most.
static void settle_trees(orienter* o, double* volumes)
{
    const stp_patch* all = o->patches->all;
    double lowest = HUGE_VAL;
    for (uint32_t i = 0; i < o->patches->count; ++i) {
        lowest = fmin(lowest, (double)all[i].place.y);
        volumes[i] = 0.0;
        o->pieces[i] = 1; // now sizes of subtrees
    }
    for (uint32_t at = o->tree.count; at-- > 0;) {
        uint32_t i = o->tree.sequence[at], parent = o->tree.parents[i];
        double up = (double)all[i].count * (double)normal_of(o, i).y;
        volumes[i] += up * ((double)all[i].place.y - lowest);
        volumes[parent] += parent != i ? volumes[i] : 0.0;
        o->pieces[parent] += parent != i ? o->pieces[i] : 0;
    }
    for (uint32_t at = 0; at < o->tree.count; ++at) {
        uint32_t i = o->tree.sequence[at];
        volumes[i] = volumes[o->tree.parents[i]]; // the root's
        o->pieces[i] = o->pieces[o->tree.parents[i]];
        bool is_most = o->pieces[i] > o->patches->count / 2;
        o->turned[i] = o->turned[i] != (is_most && volumes[i] < 0.0);
    }
}

stp_result stp_orient_patches(stp_context* context, const stp_leaf_octree* octree,
                              stp_patches* patches, uint32_t neighbours)
{
    size_t count = patches->count;
    orienter o = {.octree = octree,
                  .patches = patches,
                  .tree = {.parents = STP_NEW_ARRAY(context, uint32_t, count + 1),
                           .depths = STP_NEW_ARRAY(context, uint32_t, count + 1),
                           .sequence = STP_NEW_ARRAY(context, uint32_t, count + 1)},
                  .pieces = STP_NEW_ARRAY(context, uint32_t, count + 1),
                  .turned = STP_NEW_ZEROED(context, bool, count + 1),
                  .done = STP_NEW_ZEROED(context, bool, count + 1)};
    stp_result result = STP_OK;
    if (o.tree.parents == NULL || o.tree.depths == NULL || o.tree.sequence == NULL ||
        o.pieces == NULL || o.turned == NULL || o.done == NULL) {
        result = stp_fail_memory(context);
    }
    result =
        result == STP_OK ? stp_patch_links_make(context, patches, neighbours, &o.links) : result;
    o.heap =
        result == STP_OK ? STP_NEW_ARRAY(context, orient_step, o.links.count + count + 1) : NULL;
    result = result == STP_OK && o.heap == NULL ? stp_fail_memory(context) : result;
    result = result == STP_OK ? orient_all(context, &o) : result;
    double* volumes = result == STP_OK ? STP_NEW_ARRAY(context, double, count + 1) : NULL;
    result = result == STP_OK && volumes == NULL ? stp_fail_memory(context) : result;
    if (result == STP_OK) {
        settle_trees(&o, volumes);
        for (uint32_t i = 0; i < count; ++i) {
            patches->all[i].normal = normal_of(&o, i);
        }
    }
    stp_free(context, volumes);
    stp_free(context, o.heap);
    stp_patch_links_destroy(context, &o.links);
    stp_free(context, o.done);
    stp_free(context, o.turned);
    stp_free(context, o.pieces);
    stp_free(context, o.tree.sequence);
    stp_free(context, o.tree.depths);
    stp_free(context, o.tree.parents);
    return result;
}
