// SPDX-License-Identifier: MIT
#include "builder/method_sets.h"

#include "base/core/gate.h"
#include "base/splats/prefix_table.h"
#include "builder/stored_results.h"

#include <assert.h>
#include <pthread.h>

// State shared by the sets in progress.
typedef struct run {
    const stp_scene* scene;
    const stp_build_methods_desc* desc;
    stp_build_methods* made;
    stp_build_result* origins; ///< by set
    uint32_t* uppermost;       ///< steps with coarse sets
    uint32_t uppermost_count;
    bool lacks_normals; ///< some point set has no normals
    stp_gate* gate;
    pthread_mutex_t mutex;
    pthread_mutex_t previous_mutex;
    stp_result result; ///< the first failure
} run;

static const stp_method* method_at(const run* r, size_t index)
{
    return index < r->desc->method_count ? r->desc->methods[index] : r->desc->coarse;
}

static const stp_method* method_of(const run* r, size_t set)
{
    return method_at(r, set / r->desc->plan->step_count);
}

static uint32_t step_of(const run* r, size_t set)
{
    size_t index = set / r->desc->plan->step_count, step = set % r->desc->plan->step_count;
    assert(index < r->desc->method_count || step < r->uppermost_count);
    return index < r->desc->method_count ? (uint32_t)step : r->uppermost[step];
}

// Lists the steps whose sets have splats and no set above them on some path.
static stp_result list_uppermost(run* r)
{
    const stp_scene* scene = r->scene;
    const stp_build_plan* plan = r->desc->plan;
    if (r->desc->coarse == NULL || plan->step_count == 0 || scene->root == STP_NONE) {
        return STP_OK;
    }
    bool* open = STP_NEW_ZEROED(scene->context, bool, scene->node_count);
    r->uppermost = STP_NEW_ARRAY(scene->context, uint32_t, plan->step_count);
    if (open == NULL || r->uppermost == NULL) {
        stp_free(scene->context, open);
        return stp_fail_memory(scene->context);
    }
    open[scene->root] = true;
    for (size_t i = scene->node_count; i-- > 0;) { // parents before children
        const stp_node* node = &scene->nodes[i];
        uint32_t step = plan->step_of[i];
        bool has_set = step != STP_NONE && r->desc->samples[step].count > 0;
        if (open[i] && has_set) {
            r->uppermost[r->uppermost_count++] = step;
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = scene->edges[node->first_edge + k].node;
            bool moves = (scene->nodes[child].flags & STP_OBJECT_MOVING) != 0; // no set shows it
            open[child] = open[child] || moves || (open[i] && !has_set);
        }
    }
    stp_free(scene->context, open);
    return STP_OK;
}

/// Whether a method's sets must be derived from the samples.
static bool is_derived(const run* r, const stp_method* method)
{
    return method->make != NULL && method != r->desc->alone;
}

// Looks a set up in the work folder, then in the previous output.
static bool find_set(run* r, stp_hash key, stp_splats* set)
{
    const stp_build_methods_desc* desc = r->desc;
    uint32_t unused;
    if (stp_work_find_splat_set(desc->work, key, desc->shading_count, set, &unused)) {
        return true;
    }
    pthread_mutex_lock(&r->previous_mutex);
    bool found = desc->previous != NULL &&
                 stp_previous_output_take_splat_set(desc->previous, key, desc->shading_count,
                                                    desc->work, set);
    pthread_mutex_unlock(&r->previous_mutex);
    return found;
}

static stp_result make_within(run* r, const stp_method* method, size_t step, double level,
                              uint32_t triangles, stp_hash key, stp_splats* set)
{
    stp_context* context = r->scene->context;
    stp_splats made;
    stp_node_triangles large = {0};
    stp_result result = STP_OK;
    if (triangles != 0) {
        uint32_t node = r->desc->plan->steps[step].node;
        result = stp_take_node_triangles(r->scene, node, level, triangles, &large);
    }
    if (result == STP_OK) {
        const stp_method_source source = {
            .samples = &r->desc->samples[step],
            .shadings = r->desc->growths != NULL ? r->desc->shadings : NULL,
            .corners = large.corners,
            .triangle_count = large.count,
            .two_sided = r->lacks_normals &&
                         r->scene->nodes[r->desc->plan->steps[step].node].triangle_count == 0};
        result = method->make(context, &source, r->desc->options, &made);
    }
    stp_node_triangles_destroy(context, &large);
    for (uint32_t i = 0; result == STP_OK && r->desc->growths != NULL && i < made.count; ++i) {
        made.materials[i] =
            r->desc->growths->plain[made.materials[i]]; // shapes have their own radii
    }
    if (result == STP_OK) {
        result = stp_work_store_splat_set(r->desc->work, key, &made, 0, set);
        stp_splats_destroy(context, &made);
    }
    return result;
}

static stp_result make_set(run* r, const stp_method* method, size_t step, stp_hash key,
                           stp_splats* set)
{
    const stp_splats* samples = &r->desc->samples[step];
    double level = samples->count > 0
                       ? (double)stp_prefix_table_radius(&samples->table, samples->count)
                       : HUGE_VAL;
    uint32_t triangles = 0;
    if ((method->columns & STP_SPLATS_REPLACED) != 0) {
        uint32_t node = r->desc->plan->steps[step].node;
        triangles = stp_count_node_triangles(r->scene, node, level);
    }
    stp_gate_ticket ticket;
    stp_result result = stp_gate_enter(r->gate, method->bytes(samples->count, triangles), &ticket);
    if (result == STP_OK) {
        result = make_within(r, method, step, level, triangles, key, set);
        stp_gate_leave(r->gate, &ticket);
    }
    return result;
}

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    run* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_method* method = method_of(r, i);
        size_t step = step_of(r, i);
        const stp_splats* samples = &r->desc->samples[step];
        stp_hash key = r->desc->plan->steps[step].key;
        stp_result result = STP_OK;
        if (!is_derived(r, method)) {
            r->made->sets[i] = *samples;
            key = stp_build_set_key(r->desc->alone, r->desc->options, key);
        } else {
            key = method->hash(key, r->desc->options);
            if (r->desc->growths != NULL && method != r->desc->coarse) {
                key = stp_hash_bytes(key, "radii", 5);
            }
            bool found = find_set(r, key, &r->made->sets[i]);
            result = found ? STP_OK : make_set(r, method, step, key, &r->made->sets[i]);
            r->origins[i] = (stp_build_result){key, !found};
        }
        r->made->keys[i] = key;
        pthread_mutex_lock(&r->mutex);
        r->result = r->result == STP_OK ? result : r->result;
        pthread_mutex_unlock(&r->mutex);
        if (is_derived(r, method)) {
            stp_progress_add(r->scene->context, samples->count);
        }
        if (result != STP_OK) {
            stp_parallel_stop(r->scene->context);
        }
    }
}

// Fills the directory's methods, and the nodes' sets for all but the first.
static void list_methods(const run* r)
{
    const stp_build_plan* plan = r->desc->plan;
    stp_build_methods* made = r->made;
    size_t nodes = r->scene->node_count;
    for (uint32_t m = 0; m < made->method_count; ++m) {
        const stp_method* method = method_at(r, m);
        bool is_coarse = m == r->desc->method_count;
        uint32_t* sets = made->sets_of_nodes + (m - (m > 0)) * nodes;
        made->methods[m] =
            (stp_store_method){.name = method->name,
                               .id = method->id,
                               .columns = stp_method_columns(method, r->desc->options),
                               .first_set = m * plan->step_count,
                               .set_count = is_coarse ? r->uppermost_count : plan->step_count,
                               .sets = m > 0 ? sets : NULL};
        for (size_t i = 0; m > 0 && i < nodes; ++i) {
            sets[i] = STP_STORE_NONE;
        }
        for (uint32_t i = 0; m > 0 && i < made->methods[m].set_count; ++i) {
            uint32_t set = made->methods[m].first_set + i;
            sets[plan->steps[step_of(r, set)].node] = set;
        }
    }
}

static stp_result make_all(run* r)
{
    stp_context* context = r->scene->context;
    stp_build_methods* made = r->made;
    uint32_t count = made->set_count, others = made->method_count - 1;
    made->sets = STP_NEW_ZEROED(context, stp_splats, (size_t)count + 1);
    made->keys = STP_NEW_ZEROED(context, stp_hash, (size_t)count + 1);
    made->methods = STP_NEW_ZEROED(context, stp_store_method, made->method_count);
    made->sets_of_nodes =
        STP_NEW_ARRAY(context, uint32_t, (size_t)others * r->scene->node_count + 1);
    r->origins = STP_NEW_ZEROED(context, stp_build_result, (size_t)count + 1);
    if (made->sets == NULL || made->keys == NULL || made->methods == NULL ||
        made->sets_of_nodes == NULL || r->origins == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = stp_gate_create(context, r->desc->memory_bytes, &r->gate);
    stp_loop_report report = {.stage = "methods", .unit = "samples"};
    for (uint32_t i = 0; i < count; ++i) {
        bool derived = is_derived(r, method_of(r, i));
        report.total += derived ? r->desc->samples[step_of(r, i)].count : 0;
    }
    bool derives = made->method_count > 1 || is_derived(r, r->desc->methods[0]);
    if (result == STP_OK && !derives) {
        make_some(0, count, 0, r);
    } else if (result == STP_OK && count > 0) {
        result = stp_parallel_for_reported(context, count, 1, make_some, r, &report);
    }
    result = r->result == STP_OK ? result : r->result;
    if (result == STP_OK) {
        list_methods(r);
    }
    return result;
}

// Counts the sets that were found; samples are counted elsewhere.
static void count_found(run* r)
{
    size_t derived = 0;
    for (uint32_t i = 0; i < r->made->set_count; ++i) {
        if (is_derived(r, method_of(r, i))) {
            r->origins[derived++] = r->origins[i];
        }
    }
    r->made->found = (uint32_t)stp_build_count_found(r->origins, derived);
    assert(r->made->found <= derived && "more results were found than looked up");
    r->made->made = (uint32_t)derived - r->made->found;
}

#ifndef NDEBUG
static bool are_distinct(const stp_build_methods_desc* desc)
{
    uint32_t ids = 0;
    for (uint32_t i = 0; i < desc->method_count; ++i) {
        uint32_t bit = UINT32_C(1) << (desc->methods[i]->id % 32);
        if ((ids & bit) != 0) {
            return false;
        }
        ids |= bit;
    }
    return desc->method_count > 0;
}
#endif

stp_result stp_build_methods_make(const stp_scene* scene, const stp_build_methods_desc* desc,
                                  stp_build_methods* made)
{
    stp_context* context = scene->context;
    assert(are_distinct(desc) && "a file holds each method once");
    assert(desc->alone == NULL || (desc->method_count == 1 && desc->methods[0] == desc->alone));
    *made = (stp_build_methods){0};
    run r = {.scene = scene, .desc = desc, .made = made};
    stp_result result = list_uppermost(&r);
    made->method_count = desc->method_count + (r.uppermost_count > 0);
    made->set_count = desc->method_count * desc->plan->step_count + r.uppermost_count;
    for (size_t i = 0; i < scene->point_set_count && !r.lacks_normals; ++i) {
        r.lacks_normals = scene->point_sets[i].normals == NULL;
    }
    pthread_mutex_init(&r.mutex, NULL);
    pthread_mutex_init(&r.previous_mutex, NULL);
    result = result == STP_OK ? make_all(&r) : result;
    pthread_mutex_destroy(&r.previous_mutex);
    pthread_mutex_destroy(&r.mutex);
    stp_gate_destroy(r.gate);
    if (result == STP_OK) {
        count_found(&r);
    } else {
        stp_build_methods_destroy(context, made);
    }
    stp_free(context, r.uppermost);
    stp_free(context, r.origins);
    return result;
}

void stp_build_methods_destroy(stp_context* context, stp_build_methods* made)
{
    stp_free(context, made->sets);
    stp_free(context, made->keys);
    stp_free(context, made->methods);
    stp_free(context, made->sets_of_nodes);
    *made = (stp_build_methods){0};
}
