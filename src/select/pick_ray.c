// SPDX-License-Identifier: MIT
// Traversal with a heap of nodes, ordered by the entry of the ray into their boxes. Ends when the
// nearest node lies beyond the hit.
#include "base/core/context.h"
#include "select/pick_internal.h"

#include <assert.h>

enum { MAX_RECORDS = 1 << 20 };
static const uint64_t max_tests = UINT64_C(1) << 28;

/// Stored positions are rounded, by at most an eighth of an edge: boxes are enlarged by this much.
#define WIDER 0.125

typedef struct record {
    uint32_t node, shown;
    uint32_t parent,
        slot; ///< index of the parent record, and the edge from there; the root is its own parent
    stp_affine transform;
} record;

typedef struct waiting {
    double near;
    uint32_t record;
} waiting;

typedef struct walk {
    stp_pick_work work;
    record* records;
    waiting* heap;
    size_t record_count, record_capacity, heap_count, heap_capacity;
    uint32_t met; ///< the record that the pick belongs to
} walk;

static bool comes_before(const waiting* a, const waiting* b)
{
    return a->near < b->near || (a->near == b->near && a->record < b->record);
}

static void sift_up(waiting* heap, size_t at)
{
    for (; at > 0 && comes_before(&heap[at], &heap[(at - 1) / 2]); at = (at - 1) / 2) {
        waiting swap = heap[at];
        heap[at] = heap[(at - 1) / 2];
        heap[(at - 1) / 2] = swap;
    }
}

static void sift_down(waiting* heap, size_t count)
{
    for (size_t at = 0;;) {
        size_t minimum = at, left = 2 * at + 1;
        for (size_t child = left; child < count && child <= left + 1; ++child) {
            minimum = comes_before(&heap[child], &heap[minimum]) ? child : minimum;
        }
        if (minimum == at) {
            return;
        }
        waiting swap = heap[at];
        heap[at] = heap[minimum];
        heap[minimum] = swap;
        at = minimum;
    }
}

bool stp_pick_enters(const stp_pick_work* work, const stp_affine* transform, const stp_boxd* box,
                     double wider, bool points, double* near)
{
    assert(!(wider < 0.0));
    const stp_ray* ray = &work->desc->ray;
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    stp_vec3d center = stp_affine_point(transform, stp_addd(box->min, half));
    double margin = wider * sqrt(stp_dotd(half, half)) * stp_affine_scale(transform);
    const double at[3] = {center.x - ray->origin.x, center.y - ray->origin.y,
                          center.z - ray->origin.z};
    margin += 1e-12 * (fabs(at[0]) + fabs(at[1]) + fabs(at[2]) + fabs(center.x) + fabs(center.y) +
                       fabs(center.z));
    if (points) { // upper bound of the box's distance
        double reach = sqrt(stp_dotd(half, half)) * stp_affine_scale(transform) + margin;
        double farthest = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]) + reach;
        margin += work->desc->point_base + work->desc->point_slope * farthest;
    }
    const double along[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    double first = ray->nearest, last = work->nearest;
    if (stp_boxd_is_empty(*box)) {
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        const double* row = transform->m[k];
        double reach =
            fabs(row[0]) * half.x + fabs(row[1]) * half.y + fabs(row[2]) * half.z + margin;
        if (along[k] == 0.0) {
            if (fabs(at[k]) > reach) {
                return false;
            }
            continue;
        }
        double one = (at[k] - reach) / along[k], other = (at[k] + reach) / along[k];
        first = fmax(first, fmin(one, other));
        last = fmin(last, fmax(one, other));
    }
    *near = first;
    return first <= last;
}

static stp_result push(walk* w, const record* added)
{
    stp_pick_work* work = &w->work;
    const stp_store_node* node = &work->directory->nodes[added->node];
    waiting entry = {.record = (uint32_t)w->record_count};
    assert((w->record_count == 0 || added->parent < w->record_count) && "parents come first");
    work->pick->tests += 1;
    bool points = node->point_count > 0;
    if (added->shown == STP_SHOW_NOT ||
        (added->shown == STP_SHOW_GHOST && work->desc->through_ghosts) ||
        !stp_pick_enters(work, &added->transform, &node->bounds, WIDER, points, &entry.near)) {
        return STP_OK;
    }
    if (w->record_count >= MAX_RECORDS) {
        return stp_fail(work->context, STP_ERROR_LIMIT,
                        "pick: the ray passes more than %d nodes before the first hit",
                        MAX_RECORDS);
    }
    if (!STP_MAKE_ROOM(work->context, w->records, w->record_capacity, w->record_count + 1) ||
        !STP_MAKE_ROOM(work->context, w->heap, w->heap_capacity, w->heap_count + 1)) {
        return stp_fail_memory(work->context);
    }
    w->records[w->record_count++] = *added;
    w->heap[w->heap_count] = entry;
    sift_up(w->heap, w->heap_count++);
    return STP_OK;
}

static uint32_t show_below(const walk* w, const record* at, uint32_t slot)
{
    return stp_show_of(at->shown) == STP_SHOW_MIXED
               ? stp_visibility_below(w->work.desc->visibility, at->shown, slot)
               : at->shown;
}

static stp_result open_record(walk* w, uint32_t index)
{
    stp_pick_work* work = &w->work;
    const stp_store_directory* d = work->directory;
    assert(index < w->record_count);
    record at = w->records[index]; // the array may be reallocated
    const stp_store_node* node = &d->nodes[at.node];
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < node->part_count && result == STP_OK; ++i) {
        uint32_t shown = show_below(w, &at, node->edge_count + i);
        bool skipped =
            shown == STP_SHOW_NOT || (shown == STP_SHOW_GHOST && work->desc->through_ghosts);
        double before = work->nearest;
        if (!skipped) {
            result = stp_pick_part(work, d->parts[node->first_part + i], &at.transform);
        }
        w->met = work->nearest < before ? index : w->met;
    }
    for (uint32_t i = 0; i < node->edge_count && result == STP_OK; ++i) {
        const stp_store_edge* edge = &d->edges[node->first_edge + i];
        record below = {.node = edge->node,
                        .shown = show_below(w, &at, i),
                        .parent = index,
                        .slot = i,
                        .transform = stp_affine_multiply(at.transform, edge->transform)};
        result = push(w, &below);
    }
    if (result == STP_OK && work->pick->tests > max_tests) {
        result = stp_fail(work->context, STP_ERROR_LIMIT, "pick: too many triangles near the ray");
    }
    return result;
}

static void store_path(const walk* w)
{
    stp_pick* pick = w->work.pick;
    assert(w->met < w->record_count);
    const record* met = &w->records[w->met];
    pick->holder = (stp_placed_node){.node = met->node, .transform = met->transform};
    for (uint32_t i = w->met; i != w->records[i].parent; i = w->records[i].parent) {
        pick->path_count += 1;
    }
    uint32_t at = pick->path_count;
    for (uint32_t i = w->met; i != w->records[i].parent; i = w->records[i].parent) {
        assert(w->records[i].parent < i && at > 0 && "the path leads to the root");
        at -= 1;
        if (at < STP_PICK_DEPTH) {
            pick->path[at] = w->records[i].slot;
        }
    }
}

stp_result stp_pick_ray(stp_context* context, stp_store* store, const stp_pick_desc* desc,
                        stp_pick* pick)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    *pick = (stp_pick){0};
    double length = stp_dotd(desc->ray.direction, desc->ray.direction);
    if (!(length > 0.999 && length < 1.001) || isnan(desc->ray.nearest) ||
        isnan(desc->ray.farthest) || !isfinite(stp_dotd(desc->ray.origin, desc->ray.origin))) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "pick: a ray has an origin and a direction of length 1");
    }
    walk w = {.work = {.context = context,
                       .store = store,
                       .directory = d,
                       .desc = desc,
                       .pick = pick,
                       .nearest = desc->ray.farthest}};
    stp_pick_begin(&w.work);
    stp_result result = STP_OK;
    if (d->root != STP_STORE_NONE) {
        record root = {.node = d->root,
                       .shown = desc->visibility != NULL ? stp_visibility_root(desc->visibility)
                                                         : STP_SHOW,
                       .transform = stp_affine_identity()};
        result = push(&w, &root);
    }
    while (result == STP_OK && w.heap_count > 0) {
        waiting next = w.heap[0];
        assert((w.heap_count < 2 || !comes_before(&w.heap[1], &next)) && "the nearest is first");
        w.heap[0] = w.heap[--w.heap_count];
        sift_down(w.heap, w.heap_count);
        if (next.near > w.work.nearest) {
            break;
        }
        result = open_record(&w, next.record);
    }
    if (result == STP_OK && pick->hit) {
        store_path(&w);
    }
    stp_free(context, w.records);
    stp_free(context, w.heap);
    return result;
}
