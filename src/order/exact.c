// SPDX-License-Identifier: MIT
//
// The exact greedy permutation (farthest-first traversal; Gonzalez 1985), in phases.
//
// With r the largest gap, a point whose gap is below T = (0.9 r)^2 cannot be chosen while some gap
// is at least T. So each phase takes the few points with gaps of at least T, its *front*, and
// orders them greedily in a tree small enough for the cache, until no gap of at least T is left.
// Then it pushes the chosen points to the whole set as one batch. There, each leaf records the
// points that may affect it and evaluates them when its gap reaches the front. Most leaves are
// updated far less often than points are chosen near them.
//
// The result is exactly that of choosing one by one: the largest gap first; ties go to the lowest
// position on the Morton curve. Fronts, threads and vector widths affect only the time.
#include "base/core/clock.h"
#include "base/math/math.h"
#include "order/order_kinds.h"

#include <assert.h>
#include <string.h>

enum {
    FRONT_ALL = 4096, // sets up to this size are one front
    PUSH_SIZE = 2048, // chosen points pushed to the tree per batch
    AHEAD = 12,       // prefetch distance in points
    TASK_COUNT = 32,  // minimum number of subtrees that threads share
    TOGETHER = 64, // chosen points, near each other, whose box is compared with a subtree's first
};

static const float front_ratio = 0.81f; // (0.9 r)^2 / r^2

// While few points are chosen, each gap between them covers a large share of all points, and a
// front at 0.9 r copies most of those to choose one. Phases are cheap then: few leaves reach the
// floor.
enum { EARLY = 50 };
static const float early_ratio = 0.96f;

typedef struct greedy {
    const stp_points* points;
    stp_team team;
    const stp_tree_kernels* kernels;
    stp_order_output* output;
    stp_tree tree;  // all points
    uint32_t* ids;  // index of the point at each position of the tree
    stp_tree front; // candidates of this phase
    uint32_t front_capacity;
    uint32_t front_count;
    // tree positions of the front's points, ascending; each task collects into its own part
    uint32_t* positions;
    uint8_t* is_chosen; // for each point of the front
    stp_chosen* chosen; // all chosen points, phase by phase, within a phase along the curve
    uint32_t* scratch;  // [worker][scratch_stride]
    size_t scratch_stride;
    uint32_t task_level;                 // the subtrees below the branches of this level are tasks
    uint32_t* task_counts;               // points collected by each task
    uint32_t first_chosen, chosen_count; // range of this phase in `chosen`
    stp_box* boxes; // one per TOGETHER chosen points; used only with several threads
    float floor;
} greedy;

static stp_chosen point_at(const stp_tree* tree, uint32_t position)
{
    const stp_leaf* leaf = &tree->leaves[position / STP_LEAF_SIZE];
    uint32_t lane = position % STP_LEAF_SIZE;
    stp_chosen point = {.x = leaf->x[lane], .y = leaf->y[lane], .z = leaf->z[lane]};
    if (tree->normals != NULL) {
        const stp_leaf_normals* normals = &tree->normals[position / STP_LEAF_SIZE];
        point.normal_x = normals->x[lane];
        point.normal_y = normals->y[lane];
        point.normal_z = normals->z[lane];
    }
    return point;
}

static void emit(greedy* g, uint32_t position, float gap)
{
    stp_order_output* out = g->output;
    assert(out->ordered < out->wanted && gap > 0.0f);
    out->order[out->ordered] = position; // becomes the point's index later: see name_chosen
    if (out->radii != NULL) {
        out->radii[out->ordered] = sqrtf(gap) / g->points->scale;
    }
    out->ordered += 1;
}

// Converts positions to point indices, from the `first` one on. Done in bulk, the memory latencies
// overlap; done while choosing, each would delay the next choice.
static void name_chosen(greedy* g, const uint32_t* numbers, uint32_t first)
{
    uint32_t* order = g->output->order;
    for (uint32_t i = first; i < g->output->ordered; ++i) {
        order[i] = numbers[order[i]];
    }
}

// Number of positions below one task.
static uint64_t task_span(const greedy* g)
{
    return (uint64_t)STP_LEAF_SIZE << 3 * (g->task_level + 1);
}

static void run_collect(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    greedy* g = user;
    for (size_t task = begin; task < end; ++task) {
        g->task_counts[task] =
            g->kernels->collect(&g->tree, g->task_level, (uint32_t)task, g->chosen, g->floor,
                                g->positions + task * task_span(g));
    }
}

// Refreshes the maxima above the tasks.
static void lift_gaps(stp_tree* tree, uint32_t level)
{
    for (; level + 1 < tree->level_count; ++level) {
        for (uint32_t i = 0; i < tree->level_sizes[level]; ++i) {
            float gap = -1.0f;
            for (int k = 0; k < STP_BRANCH_SIZE; ++k) {
                gap = stp_max(gap, tree->levels[level][i].gap[k]);
            }
            tree->levels[level + 1][i / STP_BRANCH_SIZE].gap[i % STP_BRANCH_SIZE] = gap;
        }
    }
}

// Finds the points with gaps of at least `floor`.
static void collect_front(greedy* g, float floor)
{
    uint32_t tasks = g->tree.level_sizes[g->task_level], count = 0;
    g->floor = floor;
    stp_team_run(&g->team, tasks, 1, run_collect, g);
    lift_gaps(&g->tree, g->task_level);
    for (uint32_t task = 0; task < tasks; ++task) {
        assert(g->task_counts[task] <= task_span(g) && count <= task * task_span(g));
        memmove(g->positions + count, g->positions + task * task_span(g),
                g->task_counts[task] * sizeof(g->positions[0]));
        count += g->task_counts[task];
    }
    g->front_count = count;
}

static void prefetch_point(const stp_tree* tree, uint32_t position)
{
    const stp_leaf* leaf = &tree->leaves[position / STP_LEAF_SIZE];
    uint32_t lane = position % STP_LEAF_SIZE;
    __builtin_prefetch(&leaf->x[lane]);
    __builtin_prefetch(&leaf->y[lane]);
    __builtin_prefetch(&leaf->z[lane]);
    __builtin_prefetch(&leaf->gap[lane]);
    if (tree->normals != NULL) {
        const stp_leaf_normals* normals = &tree->normals[position / STP_LEAF_SIZE];
        __builtin_prefetch(&normals->x[lane]);
        __builtin_prefetch(&normals->y[lane]);
        __builtin_prefetch(&normals->z[lane]);
    }
}

static void run_fill_front(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    greedy* g = user;
    for (size_t i = begin; i < end; ++i) {
        if (i + AHEAD < end) {
            prefetch_point(&g->tree, g->positions[i + AHEAD]);
        }
        uint32_t position = g->positions[i], from = position % STP_LEAF_SIZE,
                 to = i % STP_LEAF_SIZE;
        const stp_leaf* source = &g->tree.leaves[position / STP_LEAF_SIZE];
        stp_leaf* leaf = &g->front.leaves[i / STP_LEAF_SIZE];
        leaf->x[to] = source->x[from];
        leaf->y[to] = source->y[from];
        leaf->z[to] = source->z[from];
        leaf->gap[to] = source->gap[from];
        if (g->tree.normals != NULL) {
            const stp_leaf_normals* normals = &g->tree.normals[position / STP_LEAF_SIZE];
            stp_leaf_normals* out = &g->front.normals[i / STP_LEAF_SIZE];
            out->x[to] = normals->x[from];
            out->y[to] = normals->y[from];
            out->z[to] = normals->z[from];
        }
        g->is_chosen[i] = 0;
    }
}

// Builds the front's own tree, and grows it if needed.
static stp_result build_front(greedy* g)
{
    if (g->front_count > g->front_capacity) {
        uint64_t capacity = (uint64_t)g->front_count + g->front_count / 2;
        capacity = capacity < FRONT_ALL ? FRONT_ALL : capacity;
        capacity = capacity > g->points->count ? g->points->count : capacity;
        stp_tree_destroy(g->team.context, &g->front);
        stp_free(g->team.context, g->is_chosen);
        g->front_capacity = 0;
        g->is_chosen = STP_NEW_ARRAY(g->team.context, uint8_t, capacity);
        if (g->is_chosen == NULL) {
            return stp_fail_memory(g->team.context);
        }
        stp_result result = stp_tree_create(g->team.context, &g->front, (uint32_t)capacity,
                                            g->tree.normals != NULL, false);
        if (result != STP_OK) {
            return result;
        }
        g->front_capacity = (uint32_t)capacity;
    }
    assert(g->front_count > 0 && g->front_count <= g->front_capacity);
    g->front.side_penalty = g->tree.side_penalty;
    g->front.side_penalty_squared = g->tree.side_penalty_squared;
    stp_tree_resize(&g->front, g->front_count);
    stp_team_run(&g->team, g->front_count, 8192, run_fill_front, g);
    stp_tree_fit(&g->front, g->kernels, &g->team);
    return STP_OK;
}

// Chooses from the front until all its gaps are below the floor, or enough are chosen. @return the
// largest gap left in the front; below 0 where all are below the floor
static float choose_from_front(greedy* g)
{
    float gap = stp_tree_gap(&g->front);
    uint32_t count = 0, before = g->output->ordered;
    while (gap >= g->floor && g->output->ordered < g->output->wanted) {
        uint32_t at = g->kernels->farthest(&g->front);
        assert(at < g->front_count && g->is_chosen[at] == 0);
        emit(g, at, gap);
        g->is_chosen[at] = 1;
        count += 1;
        stp_chosen point = point_at(&g->front, at);
        float next = g->kernels->insert(&g->front, &point, g->floor);
        assert(next <= gap && "gaps only shrink");
        gap = next;
    }
    name_chosen(g, g->positions, before);
    name_chosen(g, g->ids, before);
    // pushed to the tree along the curve: neighbours touch the same leaves
    g->first_chosen += g->chosen_count;
    g->chosen_count = 0;
    for (uint32_t i = 0; i < g->front_count && g->chosen_count < count; ++i) {
        if (g->is_chosen[i] != 0) {
            g->chosen[g->first_chosen + g->chosen_count++] = point_at(&g->front, i);
        }
    }
    assert(g->first_chosen + g->chosen_count == g->output->ordered);
    return gap;
}

// Squared distance from a position to a child's box.
static float box_distance(const stp_branch* branch, uint32_t child, stp_vec3 p)
{
    float x = stp_max(0.0f, stp_max(branch->low_x[child] - p.x, p.x - branch->high_x[child]));
    float y = stp_max(0.0f, stp_max(branch->low_y[child] - p.y, p.y - branch->high_y[child]));
    float z = stp_max(0.0f, stp_max(branch->low_z[child] - p.z, p.z - branch->high_z[child]));
    return (x * x + y * y) + z * z;
}

// Whether a chosen point may change any gap in a box.
static bool reaches(const stp_chosen* p, const stp_branch* branch, uint32_t child)
{
    return box_distance(branch, child, (stp_vec3){p->x, p->y, p->z}) < branch->gap[child];
}

static void find_boxes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    greedy* g = user;
    for (size_t k = begin; k < end; ++k) {
        uint32_t first = (uint32_t)k * TOGETHER, last = first + TOGETHER;
        last = last < g->chosen_count ? last : g->chosen_count;
        stp_box box = stp_box_empty();
        for (uint32_t i = first; i < last; ++i) {
            const stp_chosen* p = &g->chosen[g->first_chosen + i];
            stp_box_add(&box, (stp_vec3){p->x, p->y, p->z});
        }
        g->boxes[k] = box;
    }
}

// Whether any point of a box may change a gap in a child's box. Differences and squares round the
// same way, so no affected child is missed.
static bool box_reaches(const stp_box* box, const stp_branch* branch, uint32_t child)
{
    float x = stp_max(
        0.0f, stp_max(branch->low_x[child] - box->max.x, box->min.x - branch->high_x[child]));
    float y = stp_max(
        0.0f, stp_max(branch->low_y[child] - box->max.y, box->min.y - branch->high_y[child]));
    float z = stp_max(
        0.0f, stp_max(branch->low_z[child] - box->max.z, box->min.z - branch->high_z[child]));
    return (x * x + y * y) + z * z < branch->gap[child];
}

// Pushes the phase's points into one subtree, a batch at a time.
static void push_into(greedy* g, uint32_t task, uint32_t* list)
{
    uint32_t level = g->task_level, child = task % STP_BRANCH_SIZE, count = 0;
    const stp_branch* above =
        level + 1 < g->tree.level_count ? &g->tree.levels[level + 1][task / STP_BRANCH_SIZE] : NULL;
    for (uint32_t i = 0; i < g->chosen_count; i += TOGETHER) {
        if (above != NULL && !box_reaches(&g->boxes[i / TOGETHER], above, child)) {
            continue;
        }
        uint32_t last = i + TOGETHER < g->chosen_count ? i + TOGETHER : g->chosen_count;
        for (uint32_t k = g->first_chosen + i; k < g->first_chosen + last; ++k) {
            if (above == NULL || reaches(&g->chosen[k], above, child)) {
                list[count++] = k;
            }
        }
        assert(count <= PUSH_SIZE);
        if (count > PUSH_SIZE - TOGETHER) {
            g->kernels->push(&g->tree, level, task, g->chosen, list, count, list + PUSH_SIZE);
            count = 0;
        }
    }
    if (count != 0) {
        g->kernels->push(&g->tree, level, task, g->chosen, list, count, list + PUSH_SIZE);
    }
}

static void run_push(size_t begin, size_t end, uint32_t worker, void* user)
{
    greedy* g = user;
    for (size_t task = begin; task < end; ++task) {
        push_into(g, (uint32_t)task, g->scratch + g->scratch_stride * worker);
    }
}

static void push_chosen(greedy* g)
{
    if (g->team.threads > 1) {
        stp_team_run(&g->team, (g->chosen_count + TOGETHER - 1) / TOGETHER, 16, find_boxes, g);
        stp_team_run(&g->team, g->tree.level_sizes[g->task_level], 1, run_push, g);
        return;
    }
    uint32_t last = g->first_chosen + g->chosen_count;
    for (uint32_t i = g->first_chosen, count; i < last; i += count) {
        count = last - i < PUSH_SIZE ? last - i : PUSH_SIZE;
        for (uint32_t k = 0; k < count; ++k) {
            g->scratch[k] = i + k;
        }
        g->kernels->push(&g->tree, g->tree.level_count - 1, 0, g->chosen, g->scratch, count,
                         g->scratch + PUSH_SIZE);
    }
}

// Search for the position nearest to a point; the lowest one on ties.
typedef struct nearest_search {
    const stp_tree* tree;
    stp_vec3 at;
    float squared;
    uint32_t position;
} nearest_search;

static void search_leaf(nearest_search* s, uint32_t index)
{
    for (uint32_t i = 0; i < STP_LEAF_SIZE; ++i) {
        stp_chosen p = point_at(s->tree, index * STP_LEAF_SIZE + i);
        float x = p.x - s->at.x, y = p.y - s->at.y, z = p.z - s->at.z;
        float squared = (x * x + y * y) + z * z;
        if (squared < s->squared) { // lanes past the end are copies of a lower one
            s->squared = squared;
            s->position = index * STP_LEAF_SIZE + i;
        }
    }
}

// Visits children in order, so that ties go to the lowest position. Boxes are never farther than
// their points, rounding included.
static void search_branch(nearest_search* s, uint32_t level, uint32_t index)
{
    const stp_branch* branch = &s->tree->levels[level][index];
    for (uint32_t child = 0; child < STP_BRANCH_SIZE; ++child) {
        if (branch->gap[child] < 0.0f || !(box_distance(branch, child, s->at) < s->squared)) {
            continue;
        }
        if (level == 0) {
            search_leaf(s, index * STP_BRANCH_SIZE + child);
        } else {
            search_branch(s, level - 1, index * STP_BRANCH_SIZE + child);
        }
    }
}

static uint32_t nearest_to_centre(const greedy* g)
{
    float scale = g->points->scale;
    stp_vec3 low = stp_scale(g->points->box.min, scale),
             high = stp_scale(g->points->box.max, scale);
    nearest_search search = {
        .tree = &g->tree, .at = stp_scale(stp_add(low, high), 0.5f), .squared = INFINITY};
    search_branch(&search, g->tree.level_count - 1, 0);
    return search.position;
}

static void choose_first(greedy* g)
{
    uint32_t position = nearest_to_centre(g);
    emit(g, position, INFINITY);
    name_chosen(g, g->ids, 0);
    assert(g->output->ordered == 1 && g->first_chosen == 0);
    g->chosen[0] = point_at(&g->tree, position);
    g->chosen_count = 1;
    push_chosen(g);
    collect_front(g, FLT_MAX); // brings every gap up to date
}

static float diameter(const stp_points* points)
{
    stp_vec3 low = stp_scale(points->box.min, points->scale),
             high = stp_scale(points->box.max, points->scale);
    return stp_length(stp_sub(high, low));
}

static stp_result greedy_create(greedy* g)
{
    stp_context* context = g->team.context;
    uint32_t count = g->points->count;
    bool sides = g->points->normals != NULL;
    stp_result result = stp_tree_create(context, &g->tree, count, sides, true);
    if (result != STP_OK) {
        return result;
    }
    g->tree.side_penalty = diameter(g->points);
    g->tree.side_penalty_squared = g->tree.side_penalty * g->tree.side_penalty;
    g->task_level = g->tree.level_count - 1;
    while (g->task_level > 0 && g->tree.level_sizes[g->task_level] < TASK_COUNT) {
        g->task_level -= 1;
    }
    g->scratch_stride = PUSH_SIZE + stp_tree_push_scratch(&g->tree, PUSH_SIZE);
    g->ids = STP_NEW_ARRAY(context, uint32_t, count);
    g->positions = STP_NEW_ARRAY(context, uint32_t, count);
    g->chosen = STP_NEW_ARRAY(context, stp_chosen, g->output->wanted);
    g->scratch = STP_NEW_ARRAY(context, uint32_t, g->scratch_stride * g->team.threads);
    g->task_counts = STP_NEW_ARRAY(context, uint32_t, g->tree.level_sizes[g->task_level]);
    g->boxes = STP_NEW_ARRAY(context, stp_box, g->output->wanted / TOGETHER + 1);
    if (g->ids == NULL || g->positions == NULL || g->chosen == NULL || g->scratch == NULL ||
        g->task_counts == NULL || g->boxes == NULL) {
        return stp_fail_memory(context);
    }
    result = stp_points_sort(g->points, &g->team, &g->tree, g->ids);
    if (result == STP_OK) {
        stp_tree_fit(&g->tree, g->kernels, &g->team);
    }
    return result;
}

static void greedy_destroy(greedy* g)
{
    stp_context* context = g->team.context;
    stp_tree_destroy(context, &g->tree);
    stp_tree_destroy(context, &g->front);
    stp_free(context, g->ids);
    stp_free(context, g->positions);
    stp_free(context, g->is_chosen);
    stp_free(context, g->chosen);
    stp_free(context, g->scratch);
    stp_free(context, g->task_counts);
    stp_free(context, g->boxes);
}

// Phase after phase until enough are chosen or no gap is left, and the final radius after that.
static stp_result run_phases(greedy* g)
{
    stp_order_output* out = g->output;
    float gap = stp_tree_gap(&g->tree);
    while (gap > 0.0f && (out->ordered < out->wanted || out->final_radius != NULL)) {
        float ratio = out->ordered < EARLY ? early_ratio : front_ratio;
        float floor = g->points->count <= FRONT_ALL ? FLT_TRUE_MIN : gap * ratio;
        collect_front(g, stp_max(floor, FLT_TRUE_MIN));
        gap = stp_tree_gap(&g->tree);
        if (g->front_count == 0) {
            continue;
        }
        if (out->ordered == out->wanted) {
            break; // the gap is exact now
        }
        stp_result result = build_front(g);
        if (result != STP_OK) {
            return result;
        }
        float left = choose_from_front(g);
        if (left >= g->floor) {
            gap = left;
            break;
        }
        push_chosen(g);
        gap = g->floor > FLT_TRUE_MIN ? g->floor : 0.0f; // no gap reaches the floor any more
        result = stp_progress(g->team.context, "order", (double)out->ordered / (double)out->wanted);
        if (result != STP_OK) {
            return result;
        }
    }
    if (out->final_radius != NULL) {
        *out->final_radius = gap > 0.0f ? sqrtf(gap) / g->points->scale : 0.0f;
    }
    return STP_OK;
}

stp_result stp_order_exact(const stp_points* points, const stp_team* team,
                           const stp_order_desc* desc, stp_order_output* output)
{
    stp_points used = *points;
    if (desc->metric == STP_METRIC_EUCLIDEAN) {
        used.normals = NULL;
    }
    greedy g = {
        .points = &used, .team = *team, .kernels = stp_tree_kernels_select(), .output = output};
    double start = stp_clock_ms();
    stp_result result = greedy_create(&g);
    double indexed = stp_clock_ms();
    if (result == STP_OK) {
        choose_first(&g);
        result = run_phases(&g);
    }
    output->report.index_ms = indexed - start;
    output->report.order_ms = stp_clock_ms() - indexed;
    greedy_destroy(&g);
    return result;
}
