// SPDX-License-Identifier: MIT
#include "lab/measure/box_tree.h"

#include <assert.h>

enum {
    LEAF = 4,       ///< maximum items per leaf
    BINS = 16,      ///< candidate split positions per axis
    FREE_DEPTH = 56 ///< deeper nodes are halved, which limits the depth
};

#define SLACK (1.0 + 1e-12)

/// Things [begin, end) of the order that become a node.
typedef struct range {
    uint32_t node, begin, end, level;
} range;

typedef struct bin {
    stp_box box;
    uint32_t count;
} bin;

/// Split of a node: items in bins below `bin` along `axis` go left.
typedef struct split {
    int axis; ///< negative: no split
    uint32_t bin;
    float low, scale; ///< from a box centre to a bin
} split;

typedef struct maker {
    const stp_box* boxes;
    uint32_t* order;
    stp_box_node* nodes;
    uint32_t node_count;
} maker;

static float part_of(stp_vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static void join(stp_box* box, const stp_box* other)
{
    stp_box_add(box, other->min);
    stp_box_add(box, other->max);
}

static double area_of(const stp_box* box)
{
    double x = (double)box->max.x - (double)box->min.x;
    double y = (double)box->max.y - (double)box->min.y;
    double z = (double)box->max.z - (double)box->min.z;
    return x * y + y * z + z * x;
}

/// Halves first: the sum of two floats may overflow.
static stp_vec3 middle_of(const stp_box* box)
{
    return stp_add(stp_scale(box->min, 0.5f), stp_scale(box->max, 0.5f));
}

static uint32_t bin_of(const split* c, const stp_box* box)
{
    float at = (part_of(middle_of(box), c->axis) - c->low) * c->scale;
    return at >= (float)(BINS - 1) ? BINS - 1 : at > 0.0f ? (uint32_t)at : 0;
}

// Finds the cheapest split between bins of an axis. Updates `cost` if it is cheaper.
static void try_axis(const maker* m, const range* r, const stp_box* middles, int axis, split* best,
                     double* cost)
{
    float low = part_of(middles->min, axis), high = part_of(middles->max, axis);
    split c = {.axis = axis, .low = low, .scale = (float)BINS / (high - low)};
    if (!(high > low) || !(c.scale < FLT_MAX)) {
        return;
    }
    bin bins[BINS];
    for (uint32_t i = 0; i < BINS; ++i) {
        bins[i] = (bin){.box = stp_box_empty()};
    }
    for (uint32_t i = r->begin; i < r->end; ++i) {
        const stp_box* box = &m->boxes[m->order[i]];
        bin* in = &bins[bin_of(&c, box)];
        join(&in->box, box);
        in->count += 1;
    }
    double left_cost[BINS];
    bin sum = {.box = stp_box_empty()};
    for (uint32_t i = 0; i + 1 < BINS; ++i) {
        join(&sum.box, &bins[i].box);
        sum.count += bins[i].count;
        left_cost[i + 1] = sum.count > 0 ? area_of(&sum.box) * (double)sum.count : -1.0;
    }
    sum = (bin){.box = stp_box_empty()};
    for (uint32_t i = BINS - 1; i > 0; --i) {
        join(&sum.box, &bins[i].box);
        sum.count += bins[i].count;
        double both = left_cost[i] + area_of(&sum.box) * (double)sum.count;
        if (sum.count > 0 && left_cost[i] >= 0.0 && both < *cost) {
            *cost = both;
            c.bin = i;
            *best = c;
        }
    }
}

/// Moves the items of the left side to the front. @return the start of the right side
static uint32_t divide(const maker* m, const range* r)
{
    uint32_t half = r->begin + (r->end - r->begin) / 2;
    if (r->level >= FREE_DEPTH) {
        return half;
    }
    stp_box middles = stp_box_empty();
    for (uint32_t i = r->begin; i < r->end; ++i) {
        stp_box_add(&middles, middle_of(&m->boxes[m->order[i]]));
    }
    split c = {.axis = -1};
    double cost = (double)INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        try_axis(m, r, &middles, axis, &c, &cost);
    }
    if (c.axis < 0) { // all centres coincide
        return half;
    }
    uint32_t left = r->begin;
    for (uint32_t i = r->begin; i < r->end; ++i) {
        uint32_t item = m->order[i];
        if (bin_of(&c, &m->boxes[item]) < c.bin) {
            m->order[i] = m->order[left];
            m->order[left++] = item;
        }
    }
    assert(left > r->begin && left < r->end && "both sides of a split have items");
    return left;
}

static void set_box(stp_box_node* node, const stp_box* box)
{
    for (int axis = 0; axis < 3; ++axis) {
        node->low[axis] = part_of(box->min, axis);
        node->high[axis] = part_of(box->max, axis);
    }
}

static void make_nodes(maker* m, uint32_t count)
{
    range waiting[STP_BOX_TREE_DEPTH];
    uint32_t size = 0;
    waiting[size++] = (range){.end = count};
    m->node_count = 1;
    while (size > 0) {
        range r = waiting[--size];
        assert(r.begin < r.end && r.node < m->node_count);
        stp_box box = stp_box_empty();
        for (uint32_t i = r.begin; i < r.end; ++i) {
            join(&box, &m->boxes[m->order[i]]);
        }
        stp_box_node* node = &m->nodes[r.node];
        set_box(node, &box);
        if (r.end - r.begin <= LEAF) {
            node->first = r.begin;
            node->count = r.end - r.begin;
            continue;
        }
        uint32_t middle = divide(m, &r), first = m->node_count;
        node->first = first;
        node->count = 0;
        assert(m->node_count + 2 <= 2 * (size_t)count && size + 2 <= STP_BOX_TREE_DEPTH);
        m->node_count += 2;
        waiting[size++] = (range){first + 1, middle, r.end, r.level + 1};
        waiting[size++] = (range){first, r.begin, middle, r.level + 1};
    }
}

stp_result stp_box_tree_create(stp_context* context, const stp_box* boxes, uint32_t count,
                               stp_box_tree* tree)
{
    assert(count <= INT32_MAX && "nodes have 32-bit indices");
    *tree = (stp_box_tree){.count = count};
    if (count == 0) {
        return STP_OK;
    }
    tree->order = STP_NEW_ARRAY(context, uint32_t, count);
    tree->nodes = STP_NEW_ARRAY(context, stp_box_node, 2 * (size_t)count);
    if (tree->order == NULL || tree->nodes == NULL) {
        stp_box_tree_destroy(context, tree);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < count; ++i) {
        tree->order[i] = i;
    }
    maker m = {.boxes = boxes, .order = tree->order, .nodes = tree->nodes};
    make_nodes(&m, count);
    return STP_OK;
}

void stp_box_tree_destroy(stp_context* context, stp_box_tree* tree)
{
    stp_free(context, tree->nodes);
    stp_free(context, tree->order);
    *tree = (stp_box_tree){0};
}

static double inverse_of(double part)
{
    return 1.0 / (part == 0.0 ? 1e-300 : part);
}

stp_box_ray stp_box_ray_make(stp_vec3d origin, stp_vec3d direction)
{
    return (stp_box_ray){
        .origin = {origin.x, origin.y, origin.z},
        .inverse = {inverse_of(direction.x), inverse_of(direction.y), inverse_of(direction.z)},
    };
}

static bool enters(const stp_box_node* node, const stp_box_ray* ray, double nearest,
                   double farthest, double* near)
{
    for (int k = 0; k < 3; ++k) {
        double one = ((double)node->low[k] - ray->origin[k]) * ray->inverse[k];
        double other = ((double)node->high[k] - ray->origin[k]) * ray->inverse[k];
        double first = one < other ? one : other, last = one < other ? other : one;
        nearest = first > nearest ? first : nearest;
        farthest = last < farthest ? last : farthest;
    }
    *near = nearest;
    return nearest <= farthest * SLACK;
}

void stp_box_tree_walk(const stp_box_tree* tree, const stp_box_ray* ray, double nearest,
                       const double* farthest, void (*look)(uint32_t item, void* user), void* user)
{
    struct {
        uint32_t node;
        double near;
    } waiting[STP_BOX_TREE_DEPTH];
    uint32_t size = 0;
    double near[2];
    if (tree->count == 0 || !enters(tree->nodes, ray, nearest, *farthest, &near[0])) {
        return;
    }
    waiting[size].node = 0;
    waiting[size++].near = near[0];
    while (size > 0) {
        size -= 1;
        if (waiting[size].near > *farthest * SLACK) {
            continue;
        }
        const stp_box_node* node = &tree->nodes[waiting[size].node];
        assert(node->count == 0 || node->first + node->count <= tree->count);
        for (uint32_t i = 0; i < node->count; ++i) {
            look(tree->order[node->first + i], user);
        }
        if (node->count > 0) {
            continue;
        }
        bool in[2];
        for (uint32_t k = 0; k < 2; ++k) {
            in[k] = enters(&tree->nodes[node->first + k], ray, nearest, *farthest, &near[k]);
        }
        uint32_t later = near[0] <= near[1] ? 1 : 0; // visit the nearer one first
        for (uint32_t k = 0; k < 2; ++k) {
            uint32_t child = k == 0 ? later : 1 - later;
            if (in[child]) {
                assert(size < STP_BOX_TREE_DEPTH);
                waiting[size].node = node->first + child;
                waiting[size++].near = near[child];
            }
        }
    }
}
