// SPDX-License-Identifier: MIT
#include "builder/set_plan.h"

#include "base/core/saturate.h"
#include "scene/finish_steps.h"
#include "scene/looks.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// A node gets a set if its spacing is at most this fraction of that of the nearest set above, or if
// it has this many times fewer triangles.
#define FINER 0.5
#define SMALLER 256.0
// Or if the nearest sets above hold this many copies of it: its own set shows them all.
#define COPIES 8.0
// A set above others pays if they would each be drawn with fewer splats than this, or if it has
// this many times fewer splats than they have (hidden surfaces are left out).
#define ITEM_SPLATS 250.0
#define THINNER 16.0
#define COVERED 0.9       // share of a node's triangles that the sets below must represent
#define DENSE_POINTS 256  // fewer need no fine grid
#define DENSE_PART 0.25   // and so do less than this part of a node
#define FIXED_COST 1000.0 // cost of a step without its splats, in splats
// Peak memory of a step, measured with one thread and two (scripts/check_memory.py prints the sum).
// Fixed: the pictures of a capture. Per candidate: columns, order and tables. A point cloud's
// candidates are its points, with their hierarchy.
#define FIXED_BYTES (UINT64_C(40) << 20)
#define CANDIDATE_BYTES 120.0
#define POINT_BYTES 320.0
#define CANDIDATES_PER_SPLAT 18.0
#define MIN_CANDIDATES 20000.0
#define MAX_CANDIDATES 1750000.0

// Part of every key: increase when the same node and options give other splats.
static const char* const result_version = "stipple-surfels-16";

// The nearest sets above a node, over all paths to it, in the node's own space.
typedef struct above {
    double spacing;   ///< spacing of the coarsest set; infinite if some path has none
    double triangles; ///< triangles and points of the largest set; infinite likewise
    double copies;    ///< how often these sets hold the node: the sum of their paths to it
} above;

// The content of a node's set: everything below it that does not move on its own.
typedef struct resting {
    uint64_t triangles, points;
    double area; ///< total area of the triangles
    /// Points and longest side of the cloud with the most points for its square; 0: none
    double dense_points, dense_side;
} resting;

// Sums over the sets below a node.
typedef struct sets_below {
    double items;     ///< number of sets, each use counted
    double splats;    ///< splats in all of them
    double triangles; ///< triangles and points that they represent
} sets_below;

typedef struct planning {
    const stp_scene* scene;
    const stp_build_plan_desc* desc;
    resting* resting;  ///< by node
    above* above;      ///< by node
    bool* wanted;      ///< by node
    bool* reached;     ///< by node: reachable from the root
    uint32_t* heights; ///< by node: height of the highest step at or below it; 0: none
    sets_below* below; ///< by node: sums over the remaining sets
    stp_hash* keys;    ///< by node: key of its result, or of the results below it
    stp_hash* looks;   ///< by node: hash of its materials' shadings
} planning;

// Splats of a node's set. Zero leaves it to the method: all points of a point cloud.
static uint32_t count_splats(const planning* p, uint32_t index)
{
    const resting* r = &p->resting[index];
    const stp_splat_rule* rule = &p->desc->rule;
    if (r->triangles == 0 && p->scene->nodes[index].edge_count == 0) {
        return rule->maximum != 0 && r->points > rule->maximum ? rule->maximum : 0;
    }
    return (uint32_t)stp_splat_rule_count(rule, r->triangles, r->points);
}

static double count_shapes(const planning* p, uint32_t index)
{
    return (double)p->resting[index].triangles + (double)p->resting[index].points;
}

static double expected_splats(const planning* p, uint32_t index)
{
    uint32_t count = count_splats(p, index);
    return count != 0 ? (double)count : (double)p->resting[index].points;
}

// Approximate distance between neighbouring splats.
static double estimate_spacing(const planning* p, uint32_t index)
{
    const stp_node* node = &p->scene->nodes[index];
    double area = p->resting[index].area;
    if (!(area > 0.0)) {
        stp_vec3d e = stp_subd(node->bounds.max, node->bounds.min);
        area = e.x * e.y + e.y * e.z + e.z * e.x;
    }
    return sqrt(area / expected_splats(p, index));
}

static bool moves(const stp_scene* scene, uint32_t index)
{
    return (scene->nodes[index].flags & STP_OBJECT_MOVING) != 0;
}

static double longest_side(stp_boxd box)
{
    stp_vec3d side = stp_subd(box.max, box.min);
    return fmax(fmax(side.x, side.y), side.z);
}

// The root mean square scale of a transform over directions.
static double mean_scale(const stp_affine* a)
{
    double sum = 0.0;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            sum += a->m[row][column] * a->m[row][column];
        }
    }
    return sqrt(sum / 3.0);
}

// The densest cloud at or below a node, from those of its children.
static void find_dense(planning* p, uint32_t index)
{
    const stp_node* node = &p->scene->nodes[index];
    resting* r = &p->resting[index];
    if (node->edge_count == 0 && r->triangles == 0 && r->points >= DENSE_POINTS) {
        r->dense_points = (double)r->points;
        r->dense_side = longest_side(node->bounds);
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_edge* edge = &p->scene->edges[node->first_edge + i];
        const resting* below = &p->resting[edge->node];
        double side = below->dense_side * mean_scale(&edge->transform);
        if (below->dense_points > 0.0 && !moves(p->scene, edge->node) &&
            (r->dense_points <= 0.0 ||
             below->dense_points * r->dense_side * r->dense_side > r->dense_points * side * side)) {
            r->dense_points = below->dense_points;
            r->dense_side = side;
        }
    }
}

// Sums up the resting content of each node. If nothing moves, this is all of it (stp_node_measure).
static void measure_resting(planning* p)
{
    const stp_scene* scene = p->scene;
    for (uint32_t i = 0; i < scene->node_count; ++i) { // children before their parents
        const stp_node* node = &scene->nodes[i];
        resting r = {0};
        for (uint32_t k = 0; k < node->part_count; ++k) {
            stp_part part = scene->node_parts[node->first_part + k];
            bool mesh = part.kind == STP_PART_MESH;
            r.triangles =
                stp_add_saturated(r.triangles, mesh ? scene->meshes[part.index].triangle_count : 0);
            r.points =
                stp_add_saturated(r.points, mesh ? 0 : scene->point_sets[part.index].point_count);
            r.area += mesh ? scene->meshes[part.index].area : 0.0;
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const stp_edge* edge = &scene->edges[node->first_edge + k];
            const resting* below = &p->resting[edge->node];
            assert(edge->node < i && "children come before their parents");
            if (!moves(scene, edge->node)) {
                r.triangles = stp_add_saturated(r.triangles, below->triangles);
                r.points = stp_add_saturated(r.points, below->points);
                r.area += below->area * stp_affine_area_scale(&edge->transform);
            }
        }
        p->resting[i] = r;
        find_dense(p, i);
    }
}

static bool has_points(const planning* p, const stp_node* node)
{
    const stp_part* parts = &p->scene->node_parts[node->first_part];
    for (uint32_t i = 0; i < node->part_count; ++i) {
        if (parts[i].kind == STP_PART_POINTS) {
            return true;
        }
    }
    return false;
}

// Whether a node of points only places another node: that node's set shows all of it.
static bool passes_through(const planning* p, const stp_node* node, uint32_t index)
{
    if (node->part_count != 0 || node->edge_count != 1 || p->resting[index].triangles != 0) {
        return false;
    }
    return !moves(p->scene, p->scene->edges[node->first_edge].node);
}

// Whether the points of a cloud below, which has much of the node, would lie on fewer steps of the
// node's grid of positions than they get splats: a survey beside a point far away. Then the cloud's
// own set shows it.
static bool is_grid_too_coarse(const planning* p, uint32_t index)
{
    const resting* r = &p->resting[index];
    double steps =
        r->dense_side / longest_side(p->scene->nodes[index].bounds) * STP_POSITION_STEPS + 1.0;
    double part = r->dense_points / count_shapes(p, index);
    return p->scene->nodes[index].edge_count > 0 && r->dense_side > 0.0 && part > DENSE_PART &&
           expected_splats(p, index) * part > steps * steps;
}

static bool is_worth_a_set(const planning* p, uint32_t index)
{
    const stp_node* node = &p->scene->nodes[index];
    if (p->desc->threshold == STP_BUILD_NO_SPLATS) {
        return false;
    }
    if (has_points(p, node)) {
        return true; // only splats give points a size
    }
    if (passes_through(p, node, index) || is_grid_too_coarse(p, index)) {
        return false;
    }
    const resting* r = &p->resting[index];
    if (r->triangles <= p->desc->threshold && r->points == 0) {
        return false;
    }
    const above* a = &p->above[index];
    return estimate_spacing(p, index) <= FINER * a->spacing || a->copies >= COPIES ||
           count_shapes(p, index) * SMALLER <= a->triangles;
}

static void pass_down(planning* p, uint32_t index)
{
    const stp_node* node = &p->scene->nodes[index];
    above own = p->above[index];
    if (p->wanted[index]) {
        own = (above){estimate_spacing(p, index), count_shapes(p, index), 1.0};
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_edge* edge = &p->scene->edges[node->first_edge + i];
        above* below = &p->above[edge->node];
        bool moving = moves(p->scene, edge->node); // no set above shows it
        double scale = mean_scale(&edge->transform);
        double spacing = moving || !(scale > 0.0) ? HUGE_VAL : own.spacing / scale;
        double triangles = moving ? HUGE_VAL : own.triangles;
        below->spacing = spacing > below->spacing ? spacing : below->spacing;
        below->triangles = triangles > below->triangles ? triangles : below->triangles;
        below->copies += moving ? 0.0 : own.copies;
        p->reached[edge->node] = true;
    }
}

static void choose_nodes(planning* p)
{
    const stp_scene* scene = p->scene;
    p->above[scene->root] = (above){HUGE_VAL, HUGE_VAL, 0.0};
    p->reached[scene->root] = true;
    for (uint32_t i = (uint32_t)scene->node_count; i-- > 0;) { // parents before their children
        if (p->reached[i]) {
            p->wanted[i] = is_worth_a_set(p, i);
            pass_down(p, i);
        }
    }
}

static sets_below sum_below(const planning* p, const stp_node* node)
{
    sets_below sum = {0};
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        uint32_t child = p->scene->edges[node->first_edge + i].node;
        if (moves(p->scene, child)) {
            continue;
        }
        sets_below of = p->wanted[child]
                            ? (sets_below){1.0, expected_splats(p, child), count_shapes(p, child)}
                            : p->below[child];
        sum.items += of.items;
        sum.splats += of.splats;
        sum.triangles += of.triangles;
    }
    return sum;
}

// Prefixes of the sets below draw a node as well as its own set does, with as many splats. Its own
// set pays only if they are too many to examine one by one, or contain many hidden surfaces.
// Topmost sets always stay.
static void drop_needless(planning* p)
{
    const stp_scene* scene = p->scene;
    for (uint32_t i = 0; i < scene->node_count; ++i) { // children before their parents
        const stp_node* node = &scene->nodes[i];
        if (!p->reached[i]) {
            continue;
        }
        p->below[i] = sum_below(p, node);
        const sets_below* b = &p->below[i];
        bool uppermost = !(p->above[i].spacing < HUGE_VAL);
        if (p->wanted[i] && !uppermost && !moves(scene, i)) {
            double own = expected_splats(p, i);
            p->wanted[i] = b->triangles < COVERED * count_shapes(p, i) ||
                           b->items * ITEM_SPLATS > own || b->splats > THINNER * own;
        }
    }
}

static stp_hash hash_options(const planning* p)
{
    const stp_blue_desc* b = p->desc->blue;
    uint64_t numbers[] = {(uint64_t)b->order.kind, (uint64_t)b->order.metric,
                          b->order.seed,           b->order.samples,
                          b->order.interval,       b->capture.direction_count,
                          b->capture.resolution,   b->capture.wanted_candidates,
                          b->capture.no_fill,      p->desc->from_triangles};
    stp_hash hash = stp_hash_bytes((stp_hash){0}, result_version, strlen(result_version));
    return stp_hash_bytes(hash, numbers, sizeof(numbers));
}

/// Adds the shading of a material, or of a variant of one.
static stp_hash hash_shading(const planning* p, stp_hash hash, uint32_t material)
{
    uint8_t shading = p->desc->shading_of_material[material];
    hash = stp_hash_bytes(hash, &shading, 1);
    return stp_hash_bytes(hash, &p->desc->shadings[shading].flags, sizeof(uint32_t));
}

static stp_hash hash_shadings(const planning* p, const stp_node* node)
{
    const stp_scene* scene = p->scene;
    stp_hash hash = {0};
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_part part = scene->node_parts[node->first_part + i];
        uint32_t material = part.kind == STP_PART_MESH ? scene->meshes[part.index].material
                                                       : scene->point_sets[part.index].material;
        hash = hash_shading(p, hash, material);
        uint32_t name = part.kind == STP_PART_MESH ? scene->materials[material].look : 0;
        const stp_look* look = name != 0 ? &scene->looks[name - 1] : NULL;
        uint32_t variants = look != NULL ? stp_look_variants(scene, look) : 0;
        for (uint32_t k = 0; k < variants; ++k) {
            hash = hash_shading(p, hash, stp_look_index(scene, look, 0, 0) + k);
        }
        if (part.kind == STP_PART_POINTS && p->desc->blue->growths != NULL) {
            uint8_t shading = p->desc->shading_of_material[material];
            hash = stp_hash_bytes(hash, p->desc->blue->growths->of[shading], STP_GROWTHS);
        }
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        uint32_t child = scene->edges[node->first_edge + i].node;
        if (!moves(scene, child)) {
            hash = stp_hash_bytes(hash, &p->looks[child], sizeof(stp_hash));
        }
    }
    return hash;
}

// Computes keys and heights; children come before their parents.
static void address_results(planning* p)
{
    const stp_scene* scene = p->scene;
    stp_hash options = hash_options(p);
    for (uint32_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        if (!p->reached[i]) {
            continue;
        }
        uint32_t height = 0;
        stp_hash below = {0};
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = scene->edges[node->first_edge + k].node;
            if (moves(scene, child)) { // its result is not used above
                continue;
            }
            height = p->heights[child] > height ? p->heights[child] : height;
            below = stp_hash_bytes(below, &p->keys[child], sizeof(stp_hash));
        }
        p->looks[i] = hash_shadings(p, node);
        p->heights[i] = height + (p->wanted[i] ? 1 : 0);
        p->keys[i] = below;
        if (p->wanted[i]) {
            uint64_t count = count_splats(p, i);
            stp_hash all[4] = {options, node->content, p->looks[i], below};
            p->keys[i] = stp_hash_bytes((stp_hash){0}, all, sizeof(all));
            p->keys[i] = stp_hash_bytes(p->keys[i], &count, sizeof(count));
        }
    }
}

static int compare_steps(const void* left, const void* right)
{
    const stp_build_step* a = left;
    const stp_build_step* b = right;
    if (a->height != b->height) {
        return a->height < b->height ? -1 : 1;
    }
    if (a->cost < b->cost || a->cost > b->cost) {
        return a->cost > b->cost ? -1 : 1;
    }
    return a->node < b->node ? -1 : a->node > b->node ? 1 : 0;
}

// Finds the trailing heights with few steps (at most half the threads): all threads work on each of
// those.
static uint32_t count_shared(const stp_build_plan* plan, uint32_t threads)
{
    uint32_t end = plan->step_count;
    while (end > 0) {
        uint32_t begin = end;
        while (begin > 0 && plan->steps[begin - 1].height == plan->steps[end - 1].height) {
            --begin;
        }
        if (2 * (end - begin) > threads) {
            break;
        }
        end = begin;
    }
    return end;
}

static uint64_t estimate_bytes(const planning* p, uint32_t index)
{
    double splats = expected_splats(p, index);
    double bytes = (double)p->resting[index].points * POINT_BYTES;
    if (p->resting[index].triangles != 0) {
        double wanted = (double)p->desc->blue->capture.wanted_candidates;
        double candidates = wanted > 0.0 ? wanted : splats * CANDIDATES_PER_SPLAT;
        double maximum = splats > MAX_CANDIDATES ? splats : MAX_CANDIDATES;
        candidates = candidates < MIN_CANDIDATES ? MIN_CANDIDATES : candidates;
        candidates = candidates > maximum ? maximum : candidates;
        bytes = candidates * CANDIDATE_BYTES;
    }
    return FIXED_BYTES + (uint64_t)bytes;
}

// Finds the last step that each step needs: those of the sets below its node. Steps start in order,
// so the last one suffices.
static stp_result find_needs(const planning* p, stp_build_plan* plan)
{
    const stp_scene* scene = p->scene;
    uint32_t* needs = STP_NEW_ZEROED(scene->context, uint32_t, scene->node_count); // by node
    if (needs == NULL) {
        return stp_fail_memory(scene->context);
    }
    for (uint32_t i = 0; !p->desc->from_triangles && i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = scene->edges[node->first_edge + k].node;
            uint32_t step = plan->step_of[child];
            uint32_t last = step != STP_NONE ? step + 1 : needs[child];
            needs[i] = last > needs[i] && !moves(scene, child) ? last : needs[i];
        }
        if (plan->step_of[i] != STP_NONE) {
            assert(needs[i] <= plan->step_of[i] && "a step would wait for later ones");
            plan->steps[plan->step_of[i]].needs = needs[i];
        }
    }
    stp_free(scene->context, needs);
    return STP_OK;
}

static stp_result list_steps(const planning* p, stp_build_plan* plan)
{
    const stp_scene* scene = p->scene;
    stp_context* context = scene->context;
    uint32_t count = 0;
    for (size_t i = 0; i < scene->node_count; ++i) {
        count += p->wanted[i];
    }
    plan->steps = STP_NEW_ARRAY(context, stp_build_step, count);
    plan->step_of = STP_NEW_ARRAY(context, uint32_t, scene->node_count);
    if (plan->steps == NULL || plan->step_of == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < scene->node_count; ++i) {
        plan->step_of[i] = STP_NONE;
        if (!p->wanted[i]) {
            continue;
        }
        assert(p->reached[i] && p->heights[i] > 0 && "wanted without a key and a height");
        double splats = expected_splats(p, i);
        plan->steps[plan->step_count++] = (stp_build_step){
            .node = i,
            .height = p->heights[i],
            .splat_count = count_splats(p, i),
            .cost = splats + FIXED_COST,
            .bytes = estimate_bytes(p, i),
            .key = p->keys[i],
        };
    }
    assert(plan->step_count == count);
    qsort(plan->steps, plan->step_count, sizeof(plan->steps[0]), compare_steps);
    for (uint32_t i = 0; i < plan->step_count; ++i) {
        assert((i == 0 || compare_steps(&plan->steps[i - 1], &plan->steps[i]) < 0) &&
               "the order is total: the same for any sort");
        plan->step_of[plan->steps[i].node] = i;
        plan->cost += plan->steps[i].cost;
    }
    plan->shared_count = count_shared(plan, stp_context_thread_count(context));
    return find_needs(p, plan);
}

stp_result stp_build_plan_make(const stp_scene* scene, const stp_build_plan_desc* desc,
                               stp_build_plan* plan)
{
    stp_context* context = scene->context;
    size_t count = scene->node_count;
    *plan = (stp_build_plan){0};
    if (scene->root == STP_NONE) {
        return STP_OK;
    }
    assert(scene->root < count && "a finished scene");
    planning p = {.scene = scene, .desc = desc};
    p.resting = STP_NEW_ARRAY(context, resting, count);
    p.above = STP_NEW_ZEROED(context, above, count);
    p.below = STP_NEW_ZEROED(context, sets_below, count);
    p.wanted = STP_NEW_ZEROED(context, bool, count);
    p.reached = STP_NEW_ZEROED(context, bool, count);
    p.heights = STP_NEW_ZEROED(context, uint32_t, count);
    p.keys = STP_NEW_ZEROED(context, stp_hash, count);
    p.looks = STP_NEW_ZEROED(context, stp_hash, count);
    stp_result result = STP_OK;
    if (p.resting == NULL || p.above == NULL || p.below == NULL || p.wanted == NULL ||
        p.reached == NULL || p.heights == NULL || p.keys == NULL || p.looks == NULL) {
        result = stp_fail_memory(context);
    } else {
        measure_resting(&p);
        choose_nodes(&p);
        drop_needless(&p);
        address_results(&p);
        result = list_steps(&p, plan);
    }
    stp_free(context, p.looks);
    stp_free(context, p.keys);
    stp_free(context, p.heights);
    stp_free(context, p.reached);
    stp_free(context, p.wanted);
    stp_free(context, p.below);
    stp_free(context, p.above);
    stp_free(context, p.resting);
    if (result != STP_OK) {
        stp_build_plan_destroy(context, plan);
    }
    return result;
}

void stp_build_plan_destroy(stp_context* context, stp_build_plan* plan)
{
    stp_free(context, plan->steps);
    stp_free(context, plan->step_of);
    *plan = (stp_build_plan){0};
}
