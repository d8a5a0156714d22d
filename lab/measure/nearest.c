// SPDX-License-Identifier: MIT
#include "lab/measure/distribution.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { LEAF = 8 }; // ranges up to this size are not split

static void swap_points(stp_nearest* t, uint32_t a, uint32_t b)
{
    for (int k = 0; k < 3; ++k) {
        float value = t->positions[3 * (size_t)a + (size_t)k];
        t->positions[3 * (size_t)a + (size_t)k] = t->positions[3 * (size_t)b + (size_t)k];
        t->positions[3 * (size_t)b + (size_t)k] = value;
    }
    uint32_t id = t->ids[a];
    t->ids[a] = t->ids[b];
    t->ids[b] = id;
}

static uint8_t widest_axis(const stp_nearest* t, uint32_t begin, uint32_t end)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = begin; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            float value = t->positions[3 * (size_t)i + (size_t)k];
            low[k] = value < low[k] ? value : low[k];
            high[k] = value > high[k] ? value : high[k];
        }
    }
    double x = (double)high[0] - (double)low[0], y = (double)high[1] - (double)low[1],
           z = (double)high[2] - (double)low[2];
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

// Quickselect: puts the element of rank `middle` there, smaller or equal ones before and the others
// after (Hoare). A range of equal values is halved, so it cannot degenerate.
static void select_middle(stp_nearest* t, uint32_t begin, uint32_t end, uint32_t middle,
                          uint8_t axis)
{
    assert(begin <= middle && middle < end && axis < 3);
#define VALUE(i) t->positions[3 * (size_t)(i) + axis]
    while (end - begin > 1) {
        uint32_t half = begin + (end - begin) / 2, last = end - 1;
        float a = VALUE(begin), b = VALUE(half), c = VALUE(last);
        float pivot = a < b ? (b < c ? b : a < c ? c : a) : (a < c ? a : b < c ? c : b);
        int64_t i = (int64_t)begin - 1, j = (int64_t)end;
        for (;;) {
            do {
                i += 1;
            } while (VALUE(i) < pivot);
            do {
                j -= 1;
            } while (VALUE(j) > pivot);
            if (i >= j) {
                break;
            }
            swap_points(t, (uint32_t)i, (uint32_t)j);
        }
        uint32_t split = (uint32_t)j + 1; // [begin, split) <= pivot <= [split, end)
        if (split == end) {
            split = end - 1; // the pivot itself is last
        }
        assert(begin < split && split < end && "the range shrinks");
        if (middle < split) {
            end = split;
        } else {
            begin = split;
        }
    }
#undef VALUE
}

static void build(stp_nearest* t, uint32_t begin, uint32_t end)
{
    while (end - begin > LEAF) {
        uint32_t middle = begin + (end - begin) / 2;
        uint8_t axis = widest_axis(t, begin, end);
        select_middle(t, begin, end, middle, axis);
        t->axes[middle] = axis;
        build(t, begin, middle);
        begin = middle + 1;
    }
}

stp_result stp_nearest_create(stp_context* context, stp_nearest* tree, const float* points,
                              uint32_t count)
{
    *tree = (stp_nearest){.count = count};
    tree->positions = STP_NEW_ARRAY(context, float, 3 * (size_t)count);
    tree->ids = STP_NEW_ARRAY(context, uint32_t, count);
    tree->axes = STP_NEW_ARRAY(context, uint8_t, count);
    if (tree->positions == NULL || tree->ids == NULL || tree->axes == NULL) {
        stp_nearest_destroy(context, tree);
        return stp_fail_memory(context);
    }
    if (count != 0) {
        memcpy(tree->positions, points, 3 * (size_t)count * sizeof(points[0]));
    }
    for (uint32_t i = 0; i < count; ++i) {
        tree->ids[i] = i;
    }
    build(tree, 0, count);
    return STP_OK;
}

void stp_nearest_destroy(stp_context* context, stp_nearest* tree)
{
    stp_free(context, tree->positions);
    stp_free(context, tree->ids);
    stp_free(context, tree->axes);
    *tree = (stp_nearest){0};
}

typedef struct query {
    const stp_nearest* tree;
    double x, y, z, best;
    uint32_t except;
} query;

static void visit(query* q, uint32_t i)
{
    const float* p = q->tree->positions + 3 * (size_t)i;
    double x = (double)p[0] - q->x, y = (double)p[1] - q->y, z = (double)p[2] - q->z;
    double squared = x * x + y * y + z * z;
    if (squared < q->best && q->tree->ids[i] != q->except) {
        q->best = squared;
    }
}

static void search(query* q, uint32_t begin, uint32_t end)
{
    while (end - begin > LEAF) {
        uint32_t middle = begin + (end - begin) / 2;
        uint8_t axis = q->tree->axes[middle];
        assert(axis < 3);
        double at = axis == 0 ? q->x : axis == 1 ? q->y : q->z;
        double across = at - (double)q->tree->positions[3 * (size_t)middle + axis];
        search(q, across < 0.0 ? begin : middle + 1, across < 0.0 ? middle : end);
        if (across * across >= q->best) {
            return;
        }
        visit(q, middle);
        if (across < 0.0) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    for (uint32_t i = begin; i < end; ++i) {
        visit(q, i);
    }
}

double stp_nearest_squared(const stp_nearest* tree, const float* point, uint32_t except)
{
    query q = {tree,  (double)point[0], (double)point[1], (double)point[2], (double)INFINITY,
               except};
    search(&q, 0, tree->count);
    return q.best;
}
