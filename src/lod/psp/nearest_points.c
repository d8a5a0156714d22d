// SPDX-License-Identifier: MIT
#include "lod/psp/nearest_points.h"

#include "base/jobs.h"

#include <float.h>
#include <math.h>

enum {
    LEAF_POINTS = 12,
    DEPTH_MOST = 40,
    GRAIN = 1024,
};

typedef struct point_tree {
    const float* positions;
    uint32_t *order, *neighbours;
    uint8_t* axes; ///< of the middle of each range, along which it is split
    uint32_t count, k;
} point_tree;

typedef struct range {
    uint32_t begin, end;
} range;

static float at(const point_tree* t, uint32_t place, int axis)
{
    return t->positions[3 * (size_t)t->order[place] + (size_t)axis];
}

/// Whether the point at place i comes before that at j along an axis; equal ones by their index.
static bool is_before(const point_tree* t, uint32_t i, uint32_t j, int axis)
{
    float a = at(t, i, axis), b = at(t, j, axis);
    return a < b || (a == b && t->order[i] < t->order[j]);
}

static void swap(point_tree* t, uint32_t i, uint32_t j)
{
    uint32_t other = t->order[i];
    t->order[i] = t->order[j];
    t->order[j] = other;
}

/// Puts at `place` what would be there if the range were sorted, smaller ones before it, larger ones behind it.
static void select_place(point_tree* t, range of, uint32_t place, int axis)
{
    while (of.end - of.begin > 1) {
        uint32_t last = of.end - 1, middle = of.begin + (of.end - of.begin) / 2;
        // the median of three goes last
        if (is_before(t, middle, of.begin, axis)) {
            swap(t, middle, of.begin);
        }
        if (is_before(t, last, of.begin, axis)) {
            swap(t, last, of.begin);
        }
        if (is_before(t, middle, last, axis)) {
            swap(t, middle, last);
        }
        uint32_t store = of.begin;
        for (uint32_t i = of.begin; i < last; ++i) {
            if (is_before(t, i, last, axis)) {
                swap(t, i, store++);
            }
        }
        swap(t, store, last);
        if (store == place) {
            return;
        }
        of = store < place ? (range){store + 1, of.end} : (range){of.begin, store};
    }
}

static int find_widest(const point_tree* t, range of)
{
    float low[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, high[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    for (uint32_t i = of.begin; i < of.end; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            float x = at(t, i, axis);
            low[axis] = x < low[axis] ? x : low[axis];
            high[axis] = x > high[axis] ? x : high[axis];
        }
    }
    int widest = high[1] - low[1] > high[0] - low[0] ? 1 : 0;
    return high[2] - low[2] > high[widest] - low[widest] ? 2 : widest;
}

static uint32_t middle_of(range of)
{
    return of.begin + (of.end - of.begin) / 2;
}

static void build(point_tree* t)
{
    range stack[DEPTH_MOST] = {{0, t->count}};
    for (uint32_t size = 1; size > 0;) {
        range of = stack[--size];
        if (of.end - of.begin <= LEAF_POINTS) {
            continue;
        }
        uint32_t middle = middle_of(of);
        int axis = find_widest(t, of);
        select_place(t, of, middle, axis);
        t->axes[middle] = (uint8_t)axis;
        stack[size++] = (range){of.begin, middle};
        stack[size++] = (range){middle + 1, of.end};
    }
}

/// The nearest so far, ascending by distance, then index.
typedef struct found {
    uint32_t count, k, self;
    float squares[STP_NEIGHBOURS_MOST];
    uint32_t points[STP_NEIGHBOURS_MOST];
} found;

static float limit_of(const found* f)
{
    return f->count < f->k ? HUGE_VALF : f->squares[f->k - 1];
}

static void offer(const point_tree* t, uint32_t place, const float p[3], found* f)
{
    uint32_t point = t->order[place];
    const float* q = t->positions + 3 * (size_t)point;
    float x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2], square = x * x + y * y + z * z;
    if (point == f->self || square > limit_of(f)) {
        return;
    }
    uint32_t i = f->count < f->k ? f->count : f->k;
    while (i > 0 && (f->squares[i - 1] > square ||
                     (f->squares[i - 1] == square && f->points[i - 1] > point))) {
        if (i < f->k) {
            f->squares[i] = f->squares[i - 1];
            f->points[i] = f->points[i - 1];
        }
        i -= 1;
    }
    if (i < f->k) {
        f->squares[i] = square;
        f->points[i] = point;
        f->count += f->count < f->k ? 1 : 0;
    }
}

static void search(const point_tree* t, const float p[3], found* f)
{
    struct {
        range of;
        float beyond; ///< square of the distance to the plane that parts it from the point
    } stack[DEPTH_MOST] = {{{0, t->count}, 0.0f}};
    for (uint32_t size = 1; size > 0;) {
        range of = stack[--size].of;
        if (stack[size].beyond > limit_of(f)) {
            continue;
        }
        if (of.end - of.begin <= LEAF_POINTS) {
            for (uint32_t i = of.begin; i < of.end; ++i) {
                offer(t, i, p, f);
            }
            continue;
        }
        uint32_t middle = middle_of(of);
        int axis = t->axes[middle];
        float away = p[axis] - at(t, middle, axis);
        range low = {of.begin, middle}, high = {middle + 1, of.end};
        stack[size].of = away < 0.0f ? high : low;
        stack[size++].beyond = away * away;
        stack[size].of = away < 0.0f ? low : high;
        stack[size++].beyond = 0.0f;
        offer(t, middle, p, f);
    }
}

static void search_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const point_tree* t = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) { // in the tree's order: neighbours are warm
        uint32_t point = t->order[i];
        found f = {.k = t->k, .self = point};
        search(t, t->positions + 3 * (size_t)point, &f);
        uint32_t* out = t->neighbours + (size_t)t->k * point;
        for (uint32_t n = 0; n < t->k; ++n) {
            out[n] = n < f.count ? f.points[n] : UINT32_MAX;
        }
    }
}

stp_result stp_find_nearest_points(stp_context* context, const float* positions, uint32_t count,
                                   uint32_t k, uint32_t* neighbours)
{
    point_tree t = {.positions = positions,
                    .order = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1),
                    .axes = STP_NEW_ARRAY(context, uint8_t, (size_t)count + 1),
                    .neighbours = neighbours,
                    .count = count,
                    .k = k};
    bool made = t.order != NULL && t.axes != NULL;
    for (uint32_t i = 0; made && i < count; ++i) {
        t.order[i] = i;
    }
    if (made) {
        build(&t);
        stp_parallel_for(context, count, GRAIN, search_some, &t);
    }
    stp_free(context, t.order);
    stp_free(context, t.axes);
    return made ? STP_OK : stp_fail_memory(context);
}
