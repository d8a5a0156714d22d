// SPDX-License-Identifier: MIT
#include "builder/nodes.h"

#include "base/core/clock.h"
#include "base/core/gate.h"
#include "base/io/file.h"
#include "builder/stored_results.h"

#include <assert.h>
#include <pthread.h>

#define RELEASE_SPLATS (UINT64_C(4) << 20) // splats between releases of file pages
// What reading the first splats of a set makes resident, in splats: about 4 bytes each per column.
#define SET_SPLATS (STP_FAULT_AROUND / 4u)

// State shared by the steps of a run.
typedef struct run {
    const stp_scene* scene;
    const stp_build_nodes_desc* desc;
    stp_build_nodes* nodes;
    stp_capture_textures* textures;
    const stp_splats** sets; ///< by node, sets made so far
    stp_gate* gate;
    pthread_mutex_t mutex;
    pthread_cond_t advanced;
    pthread_mutex_t previous_mutex; ///< a store allows one thread at a time
    bool* done;                     ///< by step
    stp_build_result* origins;      ///< by step
    uint32_t done_count;            ///< number of leading steps that are done
    uint64_t unreleased;            ///< splats made since file pages were released
    stp_result result;              ///< the first failure
} run;

// Sets made without samples have different keys.
static stp_hash key_of(const run* r, const stp_build_step* step)
{
    return stp_build_set_key(r->desc->method, r->desc->options, step->key);
}

// Waits until the required steps are done. @return false if the run has failed meanwhile
static bool wait_for_lower(run* r, uint32_t needs)
{
    assert(needs <= r->desc->plan->step_count && "would wait forever");
    pthread_mutex_lock(&r->mutex);
    while (r->result == STP_OK && r->done_count < needs) {
        r->result = stp_condition_wait_reported(r->scene->context, &r->advanced, &r->mutex);
    }
    bool runs = r->result == STP_OK;
    pthread_mutex_unlock(&r->mutex);
    return runs;
}

// Data in files need not stay resident, whether it was read or written.
static void release_pages(const run* r)
{
    stp_work_release_pages(r->desc->work);
    if (r->scene->spill != NULL) {
        stp_spill_release_pages(r->scene->spill);
    }
}

static void end_step(run* r, uint32_t index, stp_result result, const stp_blue_report* report,
                     bool found)
{
    const stp_build_plan* plan = r->desc->plan;
    const stp_build_step* step = &plan->steps[index];
    stp_build_nodes* nodes = r->nodes;
    stp_progress_add(r->scene->context, (uint64_t)step->cost);
    pthread_mutex_lock(&r->mutex);
    assert(!r->done[index] && r->sets[step->node] == NULL && "a step ends once");
    r->sets[step->node] = &nodes->sets[index];
    r->result = r->result == STP_OK ? result : r->result;
    nodes->candidates += report->candidate_count;
    nodes->capture_ms += report->capture_ms;
    nodes->order_ms += report->order_ms;
    nodes->finish_ms += report->finish_ms;
    r->origins[index] = (stp_build_result){key_of(r, step), !found};
    r->done[index] = true;
    while (r->done_count < plan->step_count && r->done[r->done_count]) {
        r->done_count += 1;
    }
    r->unreleased += nodes->sets[index].count + SET_SPLATS * (uint64_t)report->source_sets;
    bool release = r->unreleased >= RELEASE_SPLATS;
    r->unreleased = release ? 0 : r->unreleased;
    pthread_cond_broadcast(&r->advanced);
    pthread_mutex_unlock(&r->mutex);
    if (release) {
        release_pages(r);
    }
    if (result == STP_OK) {
        stp_build_draft_add_splat_set(r->desc->draft, index, &nodes->sets[index]);
    }
}

// Looks a set up in the work folder, then in the previous output.
static bool find_step(run* r, const stp_build_step* step, stp_splats* set, stp_blue_report* report)
{
    const stp_build_nodes_desc* desc = r->desc;
    if (stp_work_find_splat_set(desc->work, key_of(r, step), desc->shading_count, set,
                                &report->candidate_count)) {
        return true;
    }
    pthread_mutex_lock(&r->previous_mutex);
    bool found = desc->previous != NULL &&
                 stp_previous_output_take_splat_set(desc->previous, key_of(r, step),
                                                    desc->shading_count, desc->work, set);
    pthread_mutex_unlock(&r->previous_mutex);
    return found;
}

static stp_result make_step(run* r, const stp_build_step* step, stp_splats* set,
                            stp_blue_report* report)
{
    stp_blue_desc blue = *r->desc->blue;
    blue.splat_count = step->splat_count;
    blue.capture.textures = r->textures;
    blue.sets = r->desc->from_triangles ? NULL : r->sets;
    stp_splats made;
    const stp_build_nodes_desc* desc = r->desc;
    stp_result result =
        desc->method != NULL
            ? desc->method->make_alone(r->scene, step->node, desc->shading_of_material, &blue,
                                       desc->options, &made, report)
            : stp_blue_make(r->scene, step->node, desc->shading_of_material, &blue, &made, report);
    if (result == STP_OK) {
        result = stp_work_store_splat_set(desc->work, key_of(r, step), &made,
                                          report->candidate_count, set);
        stp_splats_destroy(r->scene->context, &made);
    }
    return result;
}

static void run_step(run* r, uint32_t index)
{
    const stp_build_step* step = &r->desc->plan->steps[index];
    assert(index < r->desc->plan->step_count);
    assert(step->needs <= index && "a step that waits for later ones never starts");
    stp_splats* set = &r->nodes->sets[index];
    stp_blue_report report = {0};
    if (find_step(r, step, set, &report)) {
        end_step(r, index, STP_OK, &report, true);
        return;
    }
    if (!wait_for_lower(r, step->needs)) {
        return;
    }
    stp_gate_ticket ticket;
    stp_result result = stp_gate_enter(r->gate, step->bytes, &ticket);
    if (result == STP_OK) {
        result = make_step(r, step, set, &report);
        stp_gate_leave(r->gate, &ticket);
    }
    if (result != STP_OK) {
        stp_parallel_stop(r->scene->context);
    }
    end_step(r, index, result, &report, false);
}

static void run_shared(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        run_step(user, (uint32_t)i);
    }
}

static stp_result open_run(run* r)
{
    const stp_scene* scene = r->scene;
    const stp_build_plan* plan = r->desc->plan;
    stp_context* context = scene->context;
    r->nodes->sets = STP_NEW_ZEROED(context, stp_splats, plan->step_count);
    r->sets = STP_NEW_ZEROED(context, const stp_splats*, scene->node_count);
    r->done = STP_NEW_ZEROED(context, bool, plan->step_count);
    r->origins = STP_NEW_ZEROED(context, stp_build_result, plan->step_count);
    if (r->nodes->sets == NULL || r->sets == NULL || r->done == NULL || r->origins == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = stp_gate_create(context, r->desc->memory_bytes, &r->gate);
    return result == STP_OK ? stp_capture_textures_create(scene, false, &r->textures) : result;
}

// Runs one step per thread while there are enough; then single steps on all threads.
static void run_all(run* r)
{
    stp_context* context = r->scene->context;
    const stp_build_plan* plan = r->desc->plan;
    assert(plan->shared_count <= plan->step_count);
    stp_loop_report report = {.stage = "surfels", .unit = "surfels", .total = (uint64_t)plan->cost};
    stp_result result =
        stp_parallel_for_reported(context, plan->shared_count, 1, run_shared, r, &report);
    r->result = r->result == STP_OK ? result : r->result;
    for (uint32_t i = plan->shared_count; r->result == STP_OK && i < plan->step_count; ++i) {
        run_step(r, i);
    }
}

stp_result stp_build_nodes_make(const stp_scene* scene, const stp_build_nodes_desc* desc,
                                stp_build_nodes* nodes)
{
    stp_context* context = scene->context;
    const stp_build_plan* plan = desc->plan;
    *nodes = (stp_build_nodes){0};
    if (plan->step_count == 0) {
        return STP_OK;
    }
    run r = {.scene = scene, .desc = desc, .nodes = nodes};
    pthread_mutex_init(&r.mutex, NULL);
    stp_condition_init(&r.advanced);
    pthread_mutex_init(&r.previous_mutex, NULL);
    r.result = open_run(&r);
    if (r.result == STP_OK) {
        run_all(&r);
    }
    stp_capture_textures_destroy(r.textures);
    stp_gate_destroy(r.gate);
    if (r.result == STP_OK) {
        assert(r.done_count == plan->step_count && "a step was left out");
        nodes->found = (uint32_t)stp_build_count_found(r.origins, plan->step_count);
        assert(nodes->found <= plan->step_count);
        nodes->made = plan->step_count - nodes->found;
    }
    stp_free(context, r.origins);
    stp_free(context, r.done);
    stp_free(context, r.sets);
    pthread_mutex_destroy(&r.previous_mutex);
    pthread_cond_destroy(&r.advanced);
    pthread_mutex_destroy(&r.mutex);
    if (r.result != STP_OK) {
        stp_build_nodes_destroy(context, nodes);
    }
    return r.result;
}

stp_hash stp_build_set_key(const stp_method* method, const stp_method_options* options,
                           stp_hash key)
{
    return method != NULL ? stp_hash_bytes(method->hash(key, options), "alone", 5) : key;
}

void stp_build_nodes_destroy(stp_context* context, stp_build_nodes* nodes)
{
    stp_free(context, nodes->sets);
    nodes->sets = NULL;
}
