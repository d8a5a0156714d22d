// SPDX-License-Identifier: MIT
#include "lab/measure/shape_tree.h"

#include "base/core/sort.h"
#include "base/math/morton.h"

#include <assert.h>
#include <stdatomic.h>

enum {
    LEAF = 4, ///< maximum shapes per leaf
    GRAIN = 4096,
    CELLS = 1024, ///< cells of the curve along each axis
    STACK = 64,
};

#define ROUNDED 1e-6f ///< relative to the largest coordinate: margin of boxes
#define SLACK (1.0 - 1e-12)

typedef struct tree_maker {
    stp_shape_tree* tree;
    stp_box middles; ///< bounding box of all box centres
    uint64_t *keys, *scratch;
    const uint64_t* sorted;
    float margin;
    uint32_t level;
    atomic_bool bad; ///< a number is not finite
} tree_maker;

static void extend(stp_shape_box* box, int axis, double low, double high)
{
    box->low[axis] = stp_min(box->low[axis], (float)low);
    box->high[axis] = stp_max(box->high[axis], (float)high);
}

static stp_shape_box empty_box(void)
{
    return (stp_shape_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static stp_shape_box box_of_disk(const stp_disk_shape* disk)
{
    const double center[3] = {(double)disk->center.x, (double)disk->center.y,
                              (double)disk->center.z};
    const double u[3] = {(double)disk->larger.x, (double)disk->larger.y, (double)disk->larger.z};
    const double v[3] = {(double)disk->smaller.x, (double)disk->smaller.y, (double)disk->smaller.z};
    stp_shape_box box = empty_box();
    for (int k = 0; k < 3; ++k) {
        double reach = sqrt(u[k] * u[k] + v[k] * v[k]);
        extend(&box, k, center[k] - reach, center[k] + reach);
    }
    return box;
}

static stp_shape_box box_of_triangle(const stp_shapes* shapes, size_t index)
{
    stp_vec3d corners[3];
    stp_triangle_corners(shapes->positions, shapes->indices, index, corners);
    stp_shape_box box = empty_box();
    for (int i = 0; i < 3; ++i) {
        extend(&box, 0, corners[i].x, corners[i].x);
        extend(&box, 1, corners[i].y, corners[i].y);
        extend(&box, 2, corners[i].z, corners[i].z);
    }
    return box;
}

static stp_shape_box box_of(const stp_shape_tree* tree, uint32_t shape)
{
    const stp_shapes* s = &tree->shapes;
    return shape < s->disk_count ? box_of_disk(&s->disks[shape])
                                 : box_of_triangle(s, shape - s->disk_count);
}

static bool is_finite_triangle(const stp_shapes* shapes, size_t index)
{
    stp_vec3d corners[3];
    stp_triangle_corners(shapes->positions, shapes->indices, index, corners);
    return isfinite(corners[0].x + corners[0].y + corners[0].z) &&
           isfinite(corners[1].x + corners[1].y + corners[1].z) &&
           isfinite(corners[2].x + corners[2].y + corners[2].z);
}

static void check_shapes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    tree_maker* m = user;
    const stp_shapes* s = &m->tree->shapes;
    for (size_t i = begin; i < end; ++i) {
        bool good;
        if (i < s->disk_count) {
            const stp_disk_shape* disk = &s->disks[i];
            good = stp_is_finite(disk->center) && stp_is_finite(disk->larger) &&
                   stp_is_finite(disk->smaller);
        } else {
            good = is_finite_triangle(s, i - s->disk_count);
        }
        if (!good) {
            atomic_store_explicit(&m->bad, true, memory_order_relaxed);
        }
    }
}

static stp_vec3 middle_of(const stp_shape_box* box)
{
    return (stp_vec3){0.5f * box->low[0] + 0.5f * box->high[0],
                      0.5f * box->low[1] + 0.5f * box->high[1],
                      0.5f * box->low[2] + 0.5f * box->high[2]};
}

static uint32_t cell_of(float value, float low, float high)
{
    double part = ((double)value - (double)low) / ((double)high - (double)low);
    double cell = part * (double)CELLS;
    return cell > 0.0 ? cell < (double)(CELLS - 1) ? (uint32_t)cell : CELLS - 1 : 0;
}

static void find_keys(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    tree_maker* m = user;
    for (size_t i = begin; i < end; ++i) {
        stp_shape_box box = box_of(m->tree, (uint32_t)i);
        stp_vec3 middle = middle_of(&box), low = m->middles.min, high = m->middles.max;
        uint32_t x = cell_of(middle.x, low.x, high.x), y = cell_of(middle.y, low.y, high.y);
        m->keys[i] = (uint64_t)stp_morton(x, y, cell_of(middle.z, low.z, high.z)) << 32 | i;
    }
}

static uint32_t begin_of(const stp_shape_tree* tree, uint32_t level, uint32_t node)
{
    assert(level <= tree->depth && node <= (uint32_t)1 << level);
    return (uint32_t)((uint64_t)tree->count * node >> level);
}

static stp_shape_box* box_at(const stp_shape_tree* tree, uint32_t level, uint32_t node)
{
    assert(level <= tree->depth && node < (uint32_t)1 << level);
    return &tree->boxes[((size_t)1 << level) - 1 + node];
}

static void join(stp_shape_box* box, const stp_shape_box* other)
{
    for (int k = 0; k < 3; ++k) {
        box->low[k] = stp_min(box->low[k], other->low[k]);
        box->high[k] = stp_max(box->high[k], other->high[k]);
    }
}

static void make_boxes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const tree_maker* m = user;
    const stp_shape_tree* tree = m->tree;
    for (size_t i = begin; i < end; ++i) {
        uint32_t node = (uint32_t)i;
        stp_shape_box* box = box_at(tree, m->level, node);
        *box = empty_box();
        if (m->level < tree->depth) {
            join(box, box_at(tree, m->level + 1, 2 * node));
            join(box, box_at(tree, m->level + 1, 2 * node + 1));
            continue;
        }
        uint32_t last = begin_of(tree, m->level, node + 1);
        for (uint32_t k = begin_of(tree, m->level, node); k < last; ++k) {
            stp_shape_box own = box_of(tree, tree->order[k]);
            join(box, &own);
        }
        for (int k = 0; k < 3; ++k) { // margin for the rounding of distances
            box->low[k] -= m->margin;
            box->high[k] += m->margin;
        }
    }
}

// Computes the box of all centres, and the margin.
static void measure_shapes(tree_maker* m)
{
    float largest = 0.0f;
    m->middles = stp_box_empty();
    for (uint32_t i = 0; i < m->tree->count; ++i) {
        stp_shape_box box = box_of(m->tree, i);
        stp_box_add(&m->middles, middle_of(&box));
        for (int k = 0; k < 3; ++k) {
            largest = stp_max(largest, stp_max(-box.low[k], box.high[k]));
        }
    }
    m->margin = ROUNDED * largest + FLT_MIN;
}

static stp_result make(stp_context* context, tree_maker* m)
{
    stp_shape_tree* tree = m->tree;
    size_t count = tree->count;
    stp_parallel_for(context, count, GRAIN, check_shapes, m);
    if (atomic_load_explicit(&m->bad, memory_order_relaxed)) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "distances: a splat or triangle has non-finite coordinates");
    }
    while (count >> tree->depth >= LEAF) {
        tree->depth += 1;
    }
    assert(count >> tree->depth < LEAF && tree->depth < STACK / 2);
    tree->order = STP_NEW_ARRAY(context, uint32_t, count + 1);
    tree->boxes = STP_NEW_ARRAY(context, stp_shape_box, (size_t)2 << tree->depth);
    m->keys = STP_NEW_ARRAY(context, uint64_t, count + 1);
    m->scratch = STP_NEW_ARRAY(context, uint64_t, count + 1);
    if (tree->order == NULL || tree->boxes == NULL || m->keys == NULL || m->scratch == NULL) {
        return stp_fail_memory(context);
    }
    measure_shapes(m);
    stp_parallel_for(context, count, GRAIN, find_keys, m);
    m->sorted = stp_parallel_sort_u64(context, m->keys, m->scratch, count, 32, 30);
    if (m->sorted == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < count; ++i) {
        tree->order[i] = (uint32_t)m->sorted[i];
    }
    for (m->level = tree->depth + 1; m->level-- > 0;) {
        stp_parallel_for(context, (size_t)1 << m->level, GRAIN, make_boxes, m);
    }
    return STP_OK;
}

stp_result stp_shape_tree_create(stp_context* context, const stp_shapes* shapes,
                                 stp_shape_tree* tree)
{
    *tree = (stp_shape_tree){.shapes = *shapes};
    if (shapes->disk_count >= UINT32_MAX ||
        shapes->triangle_count >= UINT32_MAX - shapes->disk_count) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "distances: expected fewer than 4294967295 splats and triangles");
    }
    tree->count = (uint32_t)(shapes->disk_count + shapes->triangle_count);
    tree_maker m = {.tree = tree};
    stp_result result = make(context, &m);
    stp_free(context, m.keys);
    stp_free(context, m.scratch);
    if (result != STP_OK) {
        stp_shape_tree_destroy(context, tree);
    }
    return result;
}

void stp_shape_tree_destroy(stp_context* context, stp_shape_tree* tree)
{
    stp_free(context, tree->order);
    stp_free(context, tree->boxes);
    *tree = (stp_shape_tree){0};
}

static double distance_to_box(const stp_shape_box* box, const double point[3])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double low = (double)box->low[k] - point[k], high = point[k] - (double)box->high[k];
        double away = low > high ? low : high;
        sum += away > 0.0 ? away * away : 0.0;
    }
    return sum * SLACK;
}

static double distance_to_shape(const stp_shape_tree* tree, uint32_t place, stp_vec3d point,
                                double maximum)
{
    assert(place < tree->count);
    const stp_shapes* s = &tree->shapes;
    uint32_t shape = tree->order[place];
    if (shape < s->disk_count) {
        return stp_disk_distance_squared(&s->disks[shape], point, maximum);
    }
    stp_vec3d corners[3];
    stp_triangle_corners(s->positions, s->indices, shape - s->disk_count, corners);
    return stp_triangle_distance_squared(corners, point);
}

double stp_shape_tree_distance_squared_to(const stp_shape_tree* tree, uint32_t place,
                                          stp_vec3d point)
{
    return distance_to_shape(tree, place, point, (double)INFINITY);
}

typedef struct search_entry {
    double distance;
    uint32_t level, node;
} search_entry;

double stp_shape_tree_distance_squared(const stp_shape_tree* tree, stp_vec3d point, uint32_t* hint)
{
    const double p[3] = {point.x, point.y, point.z};
    search_entry stack[STACK];
    uint32_t place = hint != NULL && *hint < tree->count ? *hint : UINT32_MAX, size = 0;
    double best = place != UINT32_MAX ? distance_to_shape(tree, place, point, (double)INFINITY)
                                      : (double)INFINITY;
    stack[size++] = (search_entry){0.0, 0, 0};
    while (size > 0 && tree->count > 0) {
        search_entry at = stack[--size];
        if (at.distance >= best) {
            continue;
        }
        if (at.level == tree->depth) {
            uint32_t end = begin_of(tree, at.level, at.node + 1);
            for (uint32_t i = begin_of(tree, at.level, at.node); i < end; ++i) {
                double distance = distance_to_shape(tree, i, point, best);
                place = distance < best ? i : place;
                best = distance < best ? distance : best;
            }
            continue;
        }
        search_entry children[2];
        for (uint32_t k = 0; k < 2; ++k) {
            uint32_t node = 2 * at.node + k;
            children[k] = (search_entry){distance_to_box(box_at(tree, at.level + 1, node), p),
                                         at.level + 1, node};
        }
        bool swapped = children[0].distance < children[1].distance;
        assert(size + 2 <= STACK);
        stack[size++] = children[swapped ? 1 : 0]; // visit the nearer one first
        stack[size++] = children[swapped ? 0 : 1];
    }
    if (hint != NULL) {
        *hint = place;
    }
    return best;
}
