// SPDX-License-Identifier: MIT
#include "lod/psp/kd_tree.h"

#include <assert.h>

enum {
    PARALLEL_RANGES = 256, ///< number of subtrees built in parallel
    RELEASED = 8,          ///< pages are released after this many subtrees
    GRAIN = 1 << 16,
    STRIPE = 16 * GRAIN, ///< pages are released after this many points
};

typedef struct range {
    uint32_t begin, end; ///< leaves
} range;

static uint32_t middle_of(range of)
{
    assert(of.end > of.begin + 1 && "one leaf has no node");
    return of.begin + (of.end - of.begin) / 2;
}

typedef struct builder {
    stp_kd_tree* tree;
    const float* positions;
    stp_kd_point* points; ///< the same memory as the leaves
    float scale;
    range ranges[PARALLEL_RANGES];
    uint32_t range_count;
} builder;

static void read_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    const builder* b = user;
    (void)worker;
    if (b->tree->room != NULL && begin % STRIPE == 0) {
        stp_psp_room_release(b->tree->room);
    }
    for (size_t i = begin; i < end; ++i) {
        stp_kd_point* p = &b->points[i];
        *p = (stp_kd_point){.at = {HUGE_VALF, HUGE_VALF, HUGE_VALF}, .index = UINT32_MAX};
        if (i < b->tree->count) {
            for (size_t axis = 0; axis < 3; ++axis) {
                p->at[axis] = stp_kd_clean(b->positions[3 * i + axis], b->scale);
            }
            p->index = (uint32_t)i;
        }
    }
}

/// Splits a range of more than one leaf.
static void split(const builder* b, range of)
{
    stp_kd_tree* t = b->tree;
    size_t first = (size_t)of.begin * STP_KD_LEAF, end = (size_t)of.end * STP_KD_LEAF;
    size_t middle = (size_t)middle_of(of) * STP_KD_LEAF;
    end = end < t->count ? end : t->count; // padding of the last leaf stays there
    assert(middle < end && "the split is a coordinate of a point");
    int axis = stp_kd_widest(b->points + first, end - first);
    stp_kd_select(b->points + first, end - first, middle - first, axis, t->room);
    t->nodes[middle_of(of)] = (stp_kd_node){b->points[middle].at[axis], (uint32_t)axis};
}

static void split_ranges(size_t begin, size_t end, uint32_t worker, void* user)
{
    const builder* b = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        if (b->ranges[i].end - b->ranges[i].begin > 1) {
            split(b, b->ranges[i]);
        }
    }
}

/// Transposes the coordinates of a leaf in place.
static void turn_leaf(stp_kd_leaf* leaf, const stp_kd_point* points)
{
    stp_kd_leaf turned;
    for (int i = 0; i < STP_KD_LEAF; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            turned.at[axis][i] = points[i].at[axis];
        }
        turned.index[i] = points[i].index;
    }
    *leaf = turned;
}

static void build_ranges(size_t begin, size_t end, uint32_t worker, void* user)
{
    const builder* b = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        if (b->tree->room != NULL && i % RELEASED == 0) {
            stp_psp_room_release(b->tree->room);
        }
        range stack[STP_KD_DEPTH] = {b->ranges[i]};
        for (uint32_t size = 1; size > 0;) {
            range of = stack[--size];
            if (of.end - of.begin > 1) {
                assert(size + 2 <= STP_KD_DEPTH);
                split(b, of);
                stack[size++] = (range){middle_of(of), of.end};
                stack[size++] = (range){of.begin, middle_of(of)};
            } else if (of.end > of.begin) {
                turn_leaf(&b->tree->leaves[of.begin], b->points + (size_t)of.begin * STP_KD_LEAF);
            }
        }
    }
}

static void build(stp_context* context, builder* b)
{
    b->ranges[0] = (range){0, b->tree->leaf_count};
    for (b->range_count = 1; b->range_count < PARALLEL_RANGES; b->range_count *= 2) {
        stp_parallel_for(context, b->range_count, 1, split_ranges, b);
        for (uint32_t i = b->range_count; i-- > 0;) {
            range of = b->ranges[i];
            uint32_t middle = of.end - of.begin > 1 ? middle_of(of) : of.end;
            b->ranges[2 * i] = (range){of.begin, middle};
            b->ranges[2 * i + 1] = (range){middle, of.end};
        }
    }
    assert(b->ranges[0].begin == 0 && b->ranges[b->range_count - 1].end == b->tree->leaf_count);
    stp_parallel_for(context, b->range_count, 1, build_ranges, b);
}

static void* new_array(stp_context* context, const stp_psp_room* room, size_t count, size_t size)
{
    return room != NULL ? stp_psp_room_alloc(room, count, size)
                        : stp_alloc_array(context, count, size);
}

stp_result stp_kd_tree_make(stp_context* context, const float* positions, uint32_t count,
                            float scale, stp_kd_tree* tree)
{
    return stp_kd_tree_make_in(context, NULL, positions, count, scale, tree);
}

stp_result stp_kd_tree_make_in(stp_context* context, const stp_psp_room* room,
                               const float* positions, uint32_t count, float scale,
                               stp_kd_tree* tree)
{
    assert(scale > 0.0f && scale < HUGE_VALF);
    uint32_t leaves = count / STP_KD_LEAF + (count % STP_KD_LEAF != 0 ? 1 : 0);
    *tree =
        (stp_kd_tree){.leaves = new_array(context, room, (size_t)leaves + 1, sizeof(stp_kd_leaf)),
                      .nodes = new_array(context, room, (size_t)leaves + 1, sizeof(stp_kd_node)),
                      .count = count,
                      .leaf_count = leaves,
                      .room = room};
    if (tree->leaves == NULL || tree->nodes == NULL) {
        return room != NULL ? stp_psp_storage_fail(room->storage) : stp_fail_memory(context);
    }
    _Static_assert(sizeof(stp_kd_leaf) == STP_KD_LEAF * sizeof(stp_kd_point), "in place");
    builder b = {.tree = tree,
                 .positions = positions,
                 .points = (stp_kd_point*)(void*)tree->leaves,
                 .scale = scale};
    stp_parallel_for(context, (size_t)leaves * STP_KD_LEAF, GRAIN, read_points, &b);
    build(context, &b);
    return STP_OK;
}

void stp_kd_tree_destroy(stp_context* context, stp_kd_tree* tree)
{
    if (tree->room != NULL) {
        stp_psp_room_free(tree->room, tree->leaves);
        stp_psp_room_free(tree->room, tree->nodes);
    } else {
        stp_free(context, tree->leaves);
        stp_free(context, tree->nodes);
    }
    *tree = (stp_kd_tree){0};
}

stp_box stp_kd_box(const stp_kd_tree* tree)
{
    stp_box box = stp_box_empty();
    for (uint32_t i = 0; i < tree->count; ++i) {
        stp_box_add(&box, stp_kd_at(tree, i));
    }
    return box;
}

/// The nearest so far, ascending by distance.
typedef struct found {
    uint32_t count, k;
    float limit; ///< squared distance of the farthest, once there are k
    float squares[STP_NEIGHBOURS_MAX + 1];
    uint32_t* places;
} found;

static inline void insert(found* f, float square, uint32_t place)
{
    uint32_t i = f->count < f->k ? f->count++ : f->k - 1;
    for (; i > 0 && f->squares[i - 1] > square; --i) {
        f->squares[i] = f->squares[i - 1];
        f->places[i] = f->places[i - 1];
    }
    f->squares[i] = square;
    f->places[i] = place;
    f->limit = f->count < f->k ? HUGE_VALF : f->squares[f->k - 1];
}

static inline void search_leaf(const stp_kd_tree* t, uint32_t number, const float p[3],
                               uint32_t self, found* f)
{
    const stp_kd_leaf* leaf = &t->leaves[number];
    float squares[STP_KD_LEAF];
    for (int i = 0; i < STP_KD_LEAF; ++i) {
        float x = leaf->at[0][i] - p[0], y = leaf->at[1][i] - p[1], z = leaf->at[2][i] - p[2];
        squares[i] = x * x + y * y + z * z;
    }
    for (uint32_t i = 0; i < STP_KD_LEAF; ++i) {
        if (squares[i] < f->limit && number * STP_KD_LEAF + i != self) {
            insert(f, squares[i], number * STP_KD_LEAF + i);
        }
    }
}

/// Searches leaves whose cell has the given distances from the point along the axes.
static void search_range(const stp_kd_tree* t, range whole, const float beyond[3], const float p[3],
                         uint32_t self, found* f)
{
    // distances to cells are rounded like those to points, so no nearer point is missed
    struct {
        range of;
        float square, away[3]; ///< squared distance from point to cell; distance along each axis
    } stack[STP_KD_DEPTH];
    range of = whole;
    float away[3] = {beyond[0], beyond[1], beyond[2]};
    uint32_t size = 0;
    for (;;) {
        while (of.end - of.begin > 1) {
            uint32_t middle = middle_of(of);
            stp_kd_node node = t->nodes[middle];
            float from = p[node.axis] - node.split, kept = away[node.axis];
            range low = {of.begin, middle}, high = {middle, of.end};
            away[node.axis] = stp_max(fabsf(from), kept);
            float square = away[0] * away[0] + away[1] * away[1] + away[2] * away[2];
            if (square < f->limit) {
                assert(size < STP_KD_DEPTH);
                stack[size].of = from < 0.0f ? high : low;
                stack[size].square = square;
                stack[size].away[0] = away[0];
                stack[size].away[1] = away[1];
                stack[size].away[2] = away[2];
                size += 1;
            }
            away[node.axis] = kept;
            of = from < 0.0f ? low : high;
        }
        search_leaf(t, of.begin, p, self, f);
        do {
            if (size == 0) {
                return;
            }
            size -= 1;
        } while (!(stack[size].square < f->limit));
        of = stack[size].of;
        away[0] = stack[size].away[0];
        away[1] = stack[size].away[1];
        away[2] = stack[size].away[2];
    }
}

static void find_path(const stp_kd_tree* t, uint32_t leaf, stp_kd_path* path)
{
    assert(leaf < t->leaf_count);
    range of = {0, t->leaf_count};
    path->leaf = leaf;
    for (path->depth = 0; of.end - of.begin > 1; ++path->depth) {
        uint32_t middle = middle_of(of);
        range low = {of.begin, middle}, high = {middle, of.end};
        range other = leaf < middle ? high : low;
        assert(path->depth < STP_KD_DEPTH);
        path->steps[path->depth].begin = other.begin;
        path->steps[path->depth].end = other.end;
        path->steps[path->depth].node = t->nodes[middle];
        of = leaf < middle ? low : high;
    }
    assert(of.begin == leaf && "the path ends at its leaf");
}

uint32_t stp_kd_nearest(const stp_kd_tree* t, stp_kd_path* path, uint32_t place, uint32_t k,
                        uint32_t* places)
{
    assert(k > 0 && k <= STP_NEIGHBOURS_MAX && place < t->count);
    stp_vec3 at = stp_kd_at(t, place);
    const float p[3] = {at.x, at.y, at.z};
    found f;
    f.k = k;
    f.count = 0;
    f.limit = HUGE_VALF;
    f.places = places;
    if (path->leaf != place / STP_KD_LEAF) {
        find_path(t, place / STP_KD_LEAF, path);
    }
    search_leaf(t, path->leaf, p, place, &f);
    for (uint32_t step = path->depth; step-- > 0;) { // from the smallest cell outwards
        stp_kd_node node = path->steps[step].node;
        float from = fabsf(p[node.axis] - node.split);
        if (from * from < f.limit) {
            float away[3] = {0};
            away[node.axis] = from;
            search_range(t, (range){path->steps[step].begin, path->steps[step].end}, away, p, place,
                         &f);
        }
    }
    assert(f.count == (k < t->count ? k : t->count - 1) && "k, or all other points");
    return f.count;
}
