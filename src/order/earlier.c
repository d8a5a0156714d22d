// SPDX-License-Identifier: MIT
//
// Each point searches a tree of boxes over all points for its nearest neighbour of lower rank, the
// rank being its place in the order. Each box knows the lowest rank inside: boxes that hold only
// later points are skipped, as are boxes farther than the nearest point found so far. Points of no
// rank search all ranked ones. Searches do not depend on each other, so they run on all threads.
#include "base/math/math.h"
#include "order/order_kinds.h"

#include <assert.h>
#include <string.h>

enum { GRAIN = 64 }; // leaves at a time

typedef struct earlier_task {
    float farthest; ///< squared, of the points without rank
    uint64_t distance_count;
} earlier_task;

typedef struct earlier {
    stp_tree tree;
    uint32_t* ids;                     ///< by position in the tree
    uint32_t* rank_of;                 ///< by point
    uint32_t* ranks;                   ///< by position; lanes past the last point: UINT32_MAX
    uint32_t* lowest;                  ///< by leaf: lowest rank
    uint32_t* levels[STP_TREE_LEVELS]; ///< likewise, by branch
    earlier_task* tasks;
    const stp_points* points;
    stp_order_output* output;
} earlier;

typedef struct earlier_query {
    float x, y, z;
    uint32_t rank;
    float nearest; ///< squared
    uint64_t leaves;
} earlier_query;

static void search_leaf(const earlier* e, uint32_t index, earlier_query* q)
{
    const stp_leaf* leaf = &e->tree.leaves[index];
    const uint32_t* ranks = e->ranks + (size_t)index * STP_LEAF_SIZE;
    float squared[STP_LEAF_SIZE];
    for (int i = 0; i < STP_LEAF_SIZE; ++i) {
        float x = leaf->x[i] - q->x, y = leaf->y[i] - q->y, z = leaf->z[i] - q->z;
        float all = (x * x + y * y) + z * z;
        squared[i] = ranks[i] < q->rank ? all : INFINITY;
    }
    for (int i = 0; i < STP_LEAF_SIZE; ++i) {
        q->nearest = stp_min(q->nearest, squared[i]);
    }
    q->leaves += 1;
}

// A child to visit.
typedef struct near_child {
    float squared;
    uint32_t child;
} near_child;

// Lists the children that may hold a nearer point of lower rank, nearest first.
static uint32_t list_children(const earlier* e, uint32_t level, uint32_t index,
                              const earlier_query* q, near_child list[STP_BRANCH_SIZE])
{
    const stp_branch* b = &e->tree.levels[level][index];
    uint32_t size = level == 0 ? e->tree.leaf_count : e->tree.level_sizes[level - 1];
    const uint32_t* lowest = level == 0 ? e->lowest : e->levels[level - 1];
    float squared[STP_BRANCH_SIZE];
    for (int i = 0; i < STP_BRANCH_SIZE; ++i) { // 0 within the box
        float x = stp_max(stp_max(b->low_x[i] - q->x, q->x - b->high_x[i]), 0.0f);
        float y = stp_max(stp_max(b->low_y[i] - q->y, q->y - b->high_y[i]), 0.0f);
        float z = stp_max(stp_max(b->low_z[i] - q->z, q->z - b->high_z[i]), 0.0f);
        squared[i] = (x * x + y * y) + z * z;
    }
    uint32_t count = 0, first = index * STP_BRANCH_SIZE;
    assert(first < size && "a branch has children");
    for (uint32_t i = 0; i < STP_BRANCH_SIZE && first + i < size; ++i) {
        if (!(squared[i] < q->nearest) || lowest[first + i] >= q->rank) {
            continue;
        }
        uint32_t at = count++;
        for (; at > 0 && list[at - 1].squared > squared[i]; --at) {
            list[at] = list[at - 1];
        }
        list[at] = (near_child){squared[i], first + i};
    }
    return count;
}

static void search(const earlier* e, uint32_t level, uint32_t index, uint32_t own_leaf,
                   earlier_query* q)
{
    near_child list[STP_BRANCH_SIZE];
    uint32_t count = list_children(e, level, index, q, list);
    for (uint32_t i = 0; i < count && list[i].squared < q->nearest; ++i) {
        if (level > 0) {
            search(e, level - 1, list[i].child, own_leaf, q);
        } else if (list[i].child != own_leaf) {
            search_leaf(e, list[i].child, q);
        }
    }
}

static void measure_leaf(earlier* e, uint32_t index, earlier_task* task)
{
    const stp_leaf* leaf = &e->tree.leaves[index];
    assert(index < e->tree.leaf_count && e->tree.point_count == e->points->count);
    uint32_t first = index * STP_LEAF_SIZE, left = e->points->count - first;
    uint32_t count = left < STP_LEAF_SIZE ? left : STP_LEAF_SIZE;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t rank = e->ranks[first + i];
        bool chosen = rank < e->output->ordered;
        if (chosen ? e->output->radii == NULL : e->output->final_radius == NULL) {
            continue;
        }
        earlier_query q = {leaf->x[i], leaf->y[i], leaf->z[i], rank, INFINITY, 0};
        search_leaf(e, index, &q); // most neighbours are near
        search(e, e->tree.level_count - 1, 0, index, &q);
        task->distance_count += q.leaves * STP_LEAF_SIZE;
        if (chosen) {
            e->output->radii[rank] = sqrtf(q.nearest) / e->points->scale;
        } else {
            task->farthest = stp_max(task->farthest, q.nearest);
        }
    }
}

static void measure_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    earlier* e = user;
    earlier_task task = {0};
    for (size_t leaf = begin; leaf < end; ++leaf) {
        measure_leaf(e, (uint32_t)leaf, &task);
    }
    e->tasks[begin / GRAIN] = task;
}

// Ranks of points that were not chosen: after all that were.
static void rank_points(earlier* e)
{
    uint32_t count = e->points->count, lanes = e->tree.leaf_count * STP_LEAF_SIZE;
    for (uint32_t i = 0; i < count; ++i) {
        e->rank_of[i] = e->output->ordered;
    }
    for (uint32_t i = 0; i < e->output->ordered; ++i) {
        assert(e->rank_of[e->output->order[i]] == e->output->ordered && "each point once");
        e->rank_of[e->output->order[i]] = i;
    }
    for (uint32_t i = 0; i < lanes; ++i) {
        e->ranks[i] = i < count ? e->rank_of[e->ids[i]] : UINT32_MAX;
    }
}

static void find_lowest(const uint32_t* from, uint32_t count, uint32_t size, uint32_t* to)
{
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t begin = i / size;
        to[begin] = i % size == 0 || from[i] < to[begin] ? from[i] : to[begin];
    }
}

static stp_result allocate(earlier* e, stp_context* context)
{
    size_t lanes = (size_t)e->tree.leaf_count * STP_LEAF_SIZE;
    e->ids = STP_NEW_ARRAY(context, uint32_t, e->points->count);
    e->rank_of = STP_NEW_ARRAY(context, uint32_t, e->points->count);
    e->ranks = STP_NEW_ARRAY(context, uint32_t, lanes);
    e->lowest = STP_NEW_ARRAY(context, uint32_t, e->tree.leaf_count);
    e->tasks = STP_NEW_ARRAY(context, earlier_task, e->tree.leaf_count / GRAIN + 1);
    bool made = e->ids != NULL && e->rank_of != NULL && e->ranks != NULL && e->lowest != NULL &&
                e->tasks != NULL;
    for (uint32_t level = 0; level < e->tree.level_count; ++level) {
        e->levels[level] = STP_NEW_ARRAY(context, uint32_t, e->tree.level_sizes[level]);
        made = made && e->levels[level] != NULL;
    }
    return made ? STP_OK : stp_fail_memory(context);
}

static void release(earlier* e, stp_context* context)
{
    stp_tree_destroy(context, &e->tree);
    stp_free(context, e->ids);
    stp_free(context, e->rank_of);
    stp_free(context, e->ranks);
    stp_free(context, e->lowest);
    stp_free(context, e->tasks);
    for (uint32_t level = 0; level < STP_TREE_LEVELS; ++level) {
        stp_free(context, e->levels[level]);
    }
}

static stp_result prepare(earlier* e, const stp_team* team)
{
    stp_result result = stp_tree_create(team->context, &e->tree, e->points->count, false, false);
    result = result == STP_OK ? allocate(e, team->context) : result;
    result = result == STP_OK ? stp_points_sort(e->points, team, &e->tree, e->ids) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_tree_fit(&e->tree, stp_tree_kernels_select(), team);
    rank_points(e);
    find_lowest(e->ranks, e->tree.leaf_count * STP_LEAF_SIZE, STP_LEAF_SIZE, e->lowest);
    const uint32_t* below = e->lowest;
    uint32_t count = e->tree.leaf_count;
    for (uint32_t level = 0; level < e->tree.level_count; ++level) {
        find_lowest(below, count, STP_BRANCH_SIZE, e->levels[level]);
        below = e->levels[level];
        count = e->tree.level_sizes[level];
    }
    return STP_OK;
}

stp_result stp_earlier_measure(const stp_points* points, const stp_team* team,
                               stp_order_output* output)
{
    earlier e = {.points = points, .output = output};
    stp_result result = prepare(&e, team);
    if (result == STP_OK) {
        stp_team_run(team, e.tree.leaf_count, GRAIN, measure_task, &e);
        float farthest = 0.0f;
        for (uint32_t i = 0; i * GRAIN < e.tree.leaf_count; ++i) {
            farthest = stp_max(farthest, e.tasks[i].farthest);
            output->report.distance_count += e.tasks[i].distance_count;
        }
        if (output->final_radius != NULL) {
            *output->final_radius = sqrtf(farthest) / points->scale;
        }
    }
    release(&e, team->context);
    return result;
}
