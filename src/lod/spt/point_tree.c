// SPDX-License-Identifier: MIT
#include "lod/spt/point_tree.h"

#include "base/math/color.h"
#include "lod/spt/octree.h"

#include <assert.h>
#include <string.h>

enum {
    SUBTREE = 4096, ///< maximum points of a subtree that one thread builds
};

// A part of the tree, in depth-first order: a subtree, or one node above subtrees.
typedef struct task {
    stp_octree_box box;
    uint32_t node;  ///< its first node
    uint32_t after; ///< index of the next task after its subtree
} task;

typedef struct maker {
    stp_context* context;
    const stp_tree_points* points;
    const stp_tree_desc* desc;
    stp_point_tree* tree;
    stp_octree octree;
    task* tasks;
    size_t task_count, task_capacity;
    /// Subtree sizes of the nodes of a task, starting at twice the task's first point
    uint32_t* sizes;
    uint32_t* weights; ///< leaves below each node
} maker;

static stp_vec3 position_of(const stp_tree_points* points, uint32_t point)
{
    const float* p = points->positions + 3 * (size_t)point;
    return (stp_vec3){p[0], p[1], p[2]};
}

static void finish_leaf(const maker* m, uint32_t node)
{
    static const uint8_t white[3] = {255, 255, 255};
    const stp_tree_points* p = m->points;
    stp_point_tree* t = m->tree;
    uint32_t point = t->points[node];
    stp_tree_disk* disk = &t->disks[node];
    *disk = (stp_tree_disk){.center = position_of(p, point),
                            .radius = p->radii != NULL ? p->radii[point] : p->radius};
    if (p->normals != NULL) {
        const float* n = p->normals + 3 * (size_t)point;
        disk->normal = (stp_vec3){n[0], n[1], n[2]};
    }
    memcpy(t->colors + 3 * (size_t)node, p->colors != NULL ? p->colors + 3 * (size_t)point : white,
           3);
    t->errors[node] = t->perpendicular[node] = t->tangential[node] = 0.0f;
    m->weights[node] = 1;
}

// Whether a child's colour differs by more than a threshold from its parent's.
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

// Computes a node from its finished children.
static void finish_node(const maker* m, uint32_t node)
{
    stp_point_tree* t = m->tree;
    stp_tree_disk children[STP_DISK_CHILDREN];
    float weights[STP_DISK_CHILDREN], perpendicular = 0.0f, tangential = 0.0f, error = 0.0f;
    double color[3] = {0}, sum = 0.0;
    uint32_t count = 0, end = t->ends[node];
    for (uint32_t c = node + 1; c < end; c = t->ends[c]) {
        assert(count < STP_DISK_CHILDREN && t->ends[c] <= end);
        children[count] = t->disks[c];
        weights[count++] = (float)m->weights[c];
        sum += (double)m->weights[c];
        for (int k = 0; k < 3; ++k) {
            uint8_t code = t->colors[3 * (size_t)c + (size_t)k];
            color[k] += (double)m->weights[c] * (double)stp_srgb8_to_linear(code);
        }
        perpendicular = fmaxf(perpendicular, t->perpendicular[c]);
        tangential = fmaxf(tangential, t->tangential[c]);
        error = fmaxf(error, t->errors[c]);
    }
    assert(count >= 2 && "inner nodes with one child are skipped");
    uint8_t* own = t->colors + 3 * (size_t)node;
    for (int k = 0; k < 3; ++k) {
        own[k] = stp_linear_to_srgb8((float)(color[k] / sum));
    }
    bool by_diameter = m->desc->error == STP_TREE_DIAMETER;
    for (uint32_t c = node + 1; c < end && !by_diameter; c = t->ends[c]) {
        by_diameter = differs(t->colors + 3 * (size_t)c, own, m->desc->color_threshold);
    }
    t->disks[node] = stp_disk_enclose(children, weights, count);
    float diameter = 2.0f * t->disks[node].radius;
    stp_disk_error found = {diameter, diameter, diameter};
    if (!by_diameter) {
        found = stp_disk_measure(&t->disks[node], children, count);
    }
    t->perpendicular[node] = fmaxf(perpendicular, found.perpendicular);
    t->tangential[node] = fmaxf(tangential, found.tangential);
    t->errors[node] = fmaxf(error, found.geometric);
    assert(sum <= (double)m->points->count && "a point is one leaf");
    m->weights[node] = (uint32_t)sum;
}

// Adds the tasks of a box and of the boxes below it. @return false if out of memory
static bool add_tasks(maker* m, const stp_octree_box* box)
{
    size_t at = m->task_count;
    if (!STP_MAKE_ROOM(m->context, m->tasks, m->task_capacity, at + 1)) {
        return false;
    }
    m->task_count += 1;
    bool added = true;
    if (box->end - box->begin > SUBTREE) {
        stp_octree_box children[8];
        uint32_t count = stp_octree_divide(&m->octree, *box, children);
        for (uint32_t k = 0; k < count && added; ++k) {
            added = add_tasks(m, &children[k]);
        }
    }
    m->tasks[at] = (task){.box = *box, .after = (uint32_t)m->task_count};
    return added;
}

static bool is_subtree(const task* p)
{
    return p->box.end - p->box.begin <= SUBTREE;
}

// Computes the subtree sizes of all nodes of a box. @return that of the first node
static uint32_t find_sizes(const stp_octree* octree, const stp_octree_box* box, uint32_t* sizes)
{
    uint32_t size = 1;
    if (box->end - box->begin > 1) {
        stp_octree_box children[8];
        uint32_t count = stp_octree_divide(octree, *box, children);
        for (uint32_t k = 0; k < count; ++k) {
            size += find_sizes(octree, &children[k], sizes + size);
        }
    }
    assert(size < 2 * (box->end - box->begin) && "it fits from twice the first point on");
    sizes[0] = size;
    return size;
}

static void shape_tasks(size_t begin, size_t end, uint32_t worker, void* user)
{
    const maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_octree_box* box = &m->tasks[i].box;
        if (is_subtree(&m->tasks[i])) {
            (void)find_sizes(&m->octree, box, m->sizes + 2 * (size_t)box->begin);
        }
    }
}

static void number_nodes(maker* m)
{
    for (size_t i = 0; i < m->task_count; ++i) {
        task* p = &m->tasks[i];
        p->node = m->tree->count;
        m->tree->count += is_subtree(p) ? m->sizes[2 * (size_t)p->box.begin] : 1;
    }
    assert(m->tree->count < 2 * m->points->count);
}

static stp_result make_arrays(maker* m)
{
    stp_point_tree* t = m->tree;
    size_t nodes = t->count;
    t->disks = STP_NEW_ARRAY(m->context, stp_tree_disk, nodes);
    t->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * nodes);
    t->ends = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    t->points = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    t->errors = STP_NEW_ARRAY(m->context, float, nodes);
    t->perpendicular = STP_NEW_ARRAY(m->context, float, nodes);
    t->tangential = STP_NEW_ARRAY(m->context, float, nodes);
    m->weights = STP_NEW_ARRAY(m->context, uint32_t, nodes);
    bool made = t->disks != NULL && t->colors != NULL && t->ends != NULL && t->points != NULL &&
                t->errors != NULL && t->perpendicular != NULL && t->tangential != NULL &&
                m->weights != NULL;
    return made ? STP_OK : stp_fail_memory(m->context);
}

static void finish_subtree(const maker* m, const task* p)
{
    stp_point_tree* t = m->tree;
    const uint32_t* sizes = m->sizes + 2 * (size_t)p->box.begin;
    uint32_t item = p->box.begin;
    for (uint32_t i = 0; i < sizes[0]; ++i) {
        t->ends[p->node + i] = p->node + i + sizes[i];
        t->points[p->node + i] = sizes[i] == 1 ? stp_octree_point(&m->octree, item++) : UINT32_MAX;
    }
    assert(item == p->box.end && "each point is a leaf");
    for (uint32_t node = p->node + sizes[0]; node-- > p->node;) { // children before parents
        if (t->points[node] != UINT32_MAX) {
            finish_leaf(m, node);
        } else {
            finish_node(m, node);
        }
    }
}

static void finish_tasks(size_t begin, size_t end, uint32_t worker, void* user)
{
    const maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        if (is_subtree(&m->tasks[i])) {
            finish_subtree(m, &m->tasks[i]);
        }
    }
}

// There are few nodes above subtrees: one thread is enough.
static void finish_above(const maker* m)
{
    stp_point_tree* t = m->tree;
    for (size_t i = m->task_count; i-- > 0;) {
        const task* p = &m->tasks[i];
        assert(i < p->after && p->after <= m->task_count);
        if (!is_subtree(p)) {
            t->ends[p->node] = p->after < m->task_count ? m->tasks[p->after].node : t->count;
            t->points[p->node] = UINT32_MAX;
            finish_node(m, p->node);
        }
    }
}

static stp_result make_nodes(maker* m)
{
    size_t points = m->points->count;
    stp_octree_box all = {.end = m->points->count, .cell = m->octree.root};
    m->sizes = STP_NEW_ARRAY(m->context, uint32_t, 2 * points);
    if (m->sizes == NULL || !add_tasks(m, &all)) {
        return stp_fail_memory(m->context);
    }
    stp_parallel_for(m->context, m->task_count, 1, shape_tasks, m);
    number_nodes(m);
    stp_result result = make_arrays(m);
    if (result == STP_OK) {
        stp_parallel_for(m->context, m->task_count, 1, finish_tasks, m);
        finish_above(m);
        m->tree->leaf_count = m->points->count;
    }
    return result;
}

stp_result stp_point_tree_make(stp_context* context, const stp_tree_points* points,
                               const stp_tree_desc* desc, stp_point_tree* tree)
{
    *tree = (stp_point_tree){0};
    if (points->count == 0 || points->count > INT32_MAX) {
        return stp_fail(context, points->count == 0 ? STP_ERROR_ARGUMENT : STP_ERROR_LIMIT,
                        "a point tree of %u points cannot be made", points->count);
    }
    maker m = {.context = context, .points = points, .desc = desc, .tree = tree};
    stp_result result = stp_octree_make(context, points->positions, points->count, &m.octree);
    result = result == STP_OK ? make_nodes(&m) : result;
    stp_octree_destroy(context, &m.octree);
    stp_free(context, m.tasks);
    stp_free(context, m.sizes);
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

/// Whether a node's error is within the allowed error at its distance from the eye.
static bool suffices(const stp_point_tree* tree, uint32_t node, const stp_tree_view* view)
{
    const stp_tree_disk* disk = &tree->disks[node];
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
        assert(tree->ends[node] > node && tree->ends[node] <= tree->count);
        bool is_leaf = tree->ends[node] == node + 1;
        if (is_leaf || suffices(tree, node, view)) {
            nodes[count++] = node;
            node = tree->ends[node]; // skips the subtree
        } else {
            node += 1;
        }
    }
    assert(count <= tree->leaf_count && "selected subtrees are disjoint");
    return count;
}
