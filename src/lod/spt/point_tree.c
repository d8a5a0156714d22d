// SPDX-License-Identifier: MIT
#include "lod/spt/point_tree.h"

#include <string.h>

enum {
    LEVELS = 40, ///< of halving a box; what lies together still is cut by its order
};

// A box of the octree.
typedef struct cell {
    stp_vec3d center;
    double half;
} cell;

typedef struct maker {
    stp_context* context;
    const stp_tree_points* points;
    const stp_tree_desc* desc;
    stp_point_tree* tree;
    uint32_t *order, *scratch; ///< points, those of a box together
    uint32_t* weights;         ///< of nodes: leaves below
} maker;

static stp_vec3 position_of(const stp_tree_points* points, uint32_t point)
{
    const float* p = points->positions + 3 * (size_t)point;
    return (stp_vec3){p[0], p[1], p[2]};
}

static stp_result make_arrays(maker* m)
{
    size_t points = m->points->count, nodes = 2 * points;
    stp_point_tree* t = m->tree;
    t->disks = STP_NEW_ARRAY(m->context, stp_disk, nodes);
    t->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * nodes);
    t->ends = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    t->points = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    t->errors = STP_NEW_ARRAY(m->context, float, nodes);
    t->perpendicular = STP_NEW_ARRAY(m->context, float, nodes);
    t->tangential = STP_NEW_ARRAY(m->context, float, nodes);
    m->order = STP_NEW_ARRAY(m->context, uint32_t, points);
    m->scratch = STP_NEW_ARRAY(m->context, uint32_t, points);
    m->weights = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    bool made = t->disks != NULL && t->colors != NULL && t->ends != NULL && t->points != NULL &&
                t->errors != NULL && t->perpendicular != NULL && t->tangential != NULL &&
                m->order != NULL && m->scratch != NULL && m->weights != NULL;
    return made ? STP_OK : stp_fail_memory(m->context);
}

static void add_leaf(maker* m, uint32_t point)
{
    static const uint8_t white[3] = {255, 255, 255};
    const stp_tree_points* p = m->points;
    stp_point_tree* t = m->tree;
    uint32_t node = t->count++;
    stp_disk* disk = &t->disks[node];
    *disk = (stp_disk){.center = position_of(p, point),
                       .radius = p->radii != NULL ? p->radii[point] : p->radius};
    if (p->normals != NULL) {
        const float* n = p->normals + 3 * (size_t)point;
        disk->normal = (stp_vec3){n[0], n[1], n[2]};
    }
    memcpy(t->colors + 3 * (size_t)node, p->colors != NULL ? p->colors + 3 * (size_t)point : white,
           3);
    t->ends[node] = t->count;
    t->points[node] = point;
    t->errors[node] = t->perpendicular[node] = t->tangential[node] = 0.0f;
    t->leaf_count += 1;
    m->weights[node] = 1;
}

// Whether a child's colour is far from its parent's.
static bool differs(const uint8_t* a, const uint8_t* b, uint32_t threshold)
{
    for (int k = 0; k < 3; ++k) {
        uint32_t difference = a[k] > b[k] ? (uint32_t)(a[k] - b[k]) : (uint32_t)(b[k] - a[k]);
        if (difference > threshold) {
            return true;
        }
    }
    return false;
}

// What a node is, once its children are there.
static void finish_node(maker* m, uint32_t node)
{
    stp_point_tree* t = m->tree;
    stp_disk children[STP_DISK_CHILDREN];
    float weights[STP_DISK_CHILDREN], perpendicular = 0.0f, tangential = 0.0f, error = 0.0f;
    double color[3] = {0}, sum = 0.0;
    uint32_t count = 0;
    for (uint32_t c = node + 1; c < t->count; c = t->ends[c]) {
        children[count] = t->disks[c];
        weights[count++] = (float)m->weights[c];
        sum += (double)m->weights[c];
        for (int k = 0; k < 3; ++k) {
            color[k] += (double)m->weights[c] * (double)t->colors[3 * (size_t)c + (size_t)k];
        }
        perpendicular = fmaxf(perpendicular, t->perpendicular[c]);
        tangential = fmaxf(tangential, t->tangential[c]);
        error = fmaxf(error, t->errors[c]);
    }
    uint8_t* own = t->colors + 3 * (size_t)node;
    for (int k = 0; k < 3; ++k) {
        own[k] = (uint8_t)(color[k] / sum + 0.5);
    }
    bool by_diameter = m->desc->error == STP_TREE_DIAMETER;
    for (uint32_t c = node + 1; c < t->count && !by_diameter; c = t->ends[c]) {
        by_diameter = differs(t->colors + 3 * (size_t)c, own, m->desc->color_threshold);
    }
    t->disks[node] = stp_disk_enclose(children, weights, count);
    float diameter = 2.0f * t->disks[node].radius;
    stp_disk_error found = stp_disk_measure(&t->disks[node], children, count);
    if (by_diameter) {
        found = (stp_disk_error){diameter, diameter, diameter};
    }
    t->ends[node] = t->count;
    t->points[node] = UINT32_MAX;
    t->perpendicular[node] = fmaxf(perpendicular, found.perpendicular);
    t->tangential[node] = fmaxf(tangential, found.tangential);
    t->errors[node] = fmaxf(error, found.geometric);
    m->weights[node] = (uint32_t)sum;
}

// Which of eight a point lies in.
static uint32_t octant_of(const cell* box, stp_vec3 p)
{
    return ((double)p.x >= box->center.x ? 1u : 0u) | ((double)p.y >= box->center.y ? 2u : 0u) |
           ((double)p.z >= box->center.z ? 4u : 0u);
}

static cell child_cell(const cell* box, uint32_t octant)
{
    double half = 0.5 * box->half;
    return (cell){{box->center.x + ((octant & 1) != 0 ? half : -half),
                   box->center.y + ((octant & 2) != 0 ? half : -half),
                   box->center.z + ((octant & 4) != 0 ? half : -half)},
                  half};
}

// Puts the points of each octant together. begins[k] to begins[k + 1] is octant k. @return how many are not empty
static uint32_t split(maker* m, const cell* box, uint32_t begin, uint32_t end, uint32_t begins[9])
{
    uint32_t counts[8] = {0}, filled = 0;
    for (uint32_t i = begin; i < end; ++i) {
        counts[octant_of(box, position_of(m->points, m->order[i]))] += 1;
    }
    begins[0] = begin;
    for (uint32_t k = 0; k < 8; ++k) {
        begins[k + 1] = begins[k] + counts[k];
        filled += counts[k] > 0;
        counts[k] = begins[k];
    }
    if (filled > 1) {
        for (uint32_t i = begin; i < end; ++i) {
            m->scratch[counts[octant_of(box, position_of(m->points, m->order[i]))]++] = m->order[i];
        }
        memcpy(m->order + begin, m->scratch + begin, (end - begin) * sizeof(*m->order));
    }
    return filled;
}

// Adds what lies in a box: a leaf, or a node with up to eight subtrees. Boxes with one filled octant make no node.
static void add_box(maker* m, cell box, uint32_t level, uint32_t begin, uint32_t end)
{
    uint32_t begins[9], filled = 1;
    if (end - begin == 1) {
        add_leaf(m, m->order[begin]);
        return;
    }
    while (filled == 1 && level < LEVELS) {
        filled = split(m, &box, begin, end, begins);
        if (filled == 1) {
            uint32_t octant = 0;
            while (begins[octant + 1] == begin) {
                octant += 1;
            }
            box = child_cell(&box, octant);
            level += 1;
        }
    }
    if (filled == 1) { // coincident points, or nearly so
        for (uint32_t k = 0; k <= 8; ++k) {
            begins[k] = begin + (uint32_t)((uint64_t)(end - begin) * k / 8);
        }
    }
    uint32_t node = m->tree->count++;
    for (uint32_t k = 0; k < 8; ++k) {
        if (begins[k + 1] > begins[k]) {
            add_box(m, child_cell(&box, k), level + 1, begins[k], begins[k + 1]);
        }
    }
    finish_node(m, node);
}

static cell find_cell(const stp_tree_points* points)
{
    stp_boxd box = stp_boxd_empty();
    for (uint32_t i = 0; i < points->count; ++i) {
        stp_boxd_add(&box, stp_to_double(position_of(points, i)));
    }
    stp_vec3d size = stp_subd(box.max, box.min);
    double half = 0.5 * fmax(size.x, fmax(size.y, size.z));
    return (cell){stp_scaled(stp_addd(box.min, box.max), 0.5), half > 0.0 ? half : 1.0};
}

stp_result stp_point_tree_make(stp_context* context, const stp_tree_points* points,
                               const stp_tree_desc* desc, stp_point_tree* tree)
{
    *tree = (stp_point_tree){0};
    if (points->count == 0 || points->count > INT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT, "a point tree of %u points cannot be made",
                        points->count);
    }
    maker m = {.context = context, .points = points, .desc = desc, .tree = tree};
    stp_result result = make_arrays(&m);
    if (result == STP_OK) {
        for (uint32_t i = 0; i < points->count; ++i) {
            m.order[i] = i;
        }
        add_box(&m, find_cell(points), 0, 0, points->count);
    }
    stp_free(context, m.order);
    stp_free(context, m.scratch);
    stp_free(context, m.weights);
    if (result != STP_OK) {
        stp_point_tree_destroy(context, tree);
    }
    return result;
}

void stp_point_tree_destroy(stp_context* context, stp_point_tree* tree)
{
    void* arrays[] = {tree->disks,  tree->colors,        tree->ends,      tree->points,
                      tree->errors, tree->perpendicular, tree->tangential};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    *tree = (stp_point_tree){0};
}

bool stp_point_tree_suffices(const stp_point_tree* tree, uint32_t node, const stp_tree_view* view)
{
    const stp_disk* disk = &tree->disks[node];
    stp_vec3d v = stp_subd(view->eye, stp_to_double(disk->center));
    double distance = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    double error = (double)tree->errors[node];
    if (view->split && distance > 0.0) {
        stp_vec3d n = stp_to_double(disk->normal);
        double cosine = fmin(fabs(v.x * n.x + v.y * n.y + v.z * n.z) / distance, 1.0);
        double sine = sqrt(1.0 - cosine * cosine);
        double seen =
            (double)tree->perpendicular[node] * sine + (double)tree->tangential[node] * cosine;
        error = fmin(seen, error);
    }
    return error <= view->allowed * distance;
}

uint32_t stp_point_tree_traverse(const stp_point_tree* tree, const stp_tree_view* view,
                                 uint32_t* nodes)
{
    uint32_t count = 0;
    for (uint32_t node = 0; node < tree->count;) {
        bool is_leaf = tree->ends[node] == node + 1;
        if (is_leaf || stp_point_tree_suffices(tree, node, view)) {
            nodes[count++] = node;
            node = tree->ends[node]; // on, behind all below it
        } else {
            node += 1;
        }
    }
    return count;
}
