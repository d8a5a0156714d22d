// SPDX-License-Identifier: MIT
#include "builder/build_scene.h"

#include "base/core/clock.h"
#include "builder/build_levels.h"
#include "builder/draft.h"
#include "builder/meshes.h"
#include "builder/method_sets.h"
#include "builder/nodes.h"
#include "builder/set_plan.h"
#include "builder/writer_input.h"
#include "scene/looks.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define RESERVE_BYTES (UINT64_C(64) << 20) // for the directory and its texts while writing the file
#define MIN_BUDGET (UINT64_C(64) << 20)    // one node at a time is processed at any limit
#define FILE_MEMORY_SHARE 4u // share of the limit for meshes in memory; more go to the spill file

#define SAMPLE_POINTS 1000000u // points of a scan that are shown before it is read

enum { STAGES = 7 };

// Everything that a build creates, in order of creation.
typedef struct build {
    stp_context* context;
    const stp_build_desc* desc;
    stp_build_report* report;
    char* work_folder;
    stp_work* work;
    stp_previous_output* previous; ///< NULL: none
    stp_spill* spill;
    stp_build_draft* draft; ///< NULL: not wanted
    stp_scene* scene;
    stp_shading_set shadings;
    stp_blue_desc blue; ///< of the description, with the growths of the shadings
    stp_store_census census;
    bool splats_wanted;
    stp_build_plan plan;
    stp_build_nodes nodes;
    stp_build_meshes meshes;
    stp_build_levels levels;
    stp_build_methods methods;
    stp_build_content content;
    stp_stage stages[STAGES];
} build;

// Detects an unwritable output before the work starts.
static stp_result try_output(stp_context* context, const char* path)
{
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result == STP_OK) {
        stp_file_writer_abort(writer);
    }
    return result;
}

// The requested limit, or the context's; 0: none.
static uint64_t limit_bytes(const build* b)
{
    return b->desc->memory_bytes != 0 ? b->desc->memory_bytes : stp_memory_limit(b->context);
}

// Memory that the build may use: the limit, or most of the machine's.
static uint64_t usable_bytes(const build* b)
{
    return stp_usable_memory(limit_bytes(b));
}

/// Memory that the work in progress of the next step may use.
static uint64_t bytes_for_step(const build* b)
{
    uint64_t usable = usable_bytes(b), used = stp_context_live_bytes(b->context) + RESERVE_BYTES;
    return usable > used + MIN_BUDGET ? usable - used : MIN_BUDGET;
}

bool stp_build_work_folder(const char* output, char* folder, size_t size)
{
    int length = snprintf(folder, size, "%s.work", output);
    return length > 0 && (size_t)length < size;
}

static stp_result open_work(build* b)
{
    size_t size = strlen(b->desc->output) + sizeof(".work");
    b->work_folder = stp_alloc(b->context, size);
    if (b->work_folder == NULL) {
        return stp_fail_memory(b->context);
    }
    (void)stp_build_work_folder(b->desc->output, b->work_folder, size); // it fits
    stp_result result = stp_work_open(b->context, b->work_folder, b->desc->fresh, &b->work);
    stp_file_remove_stale(b->context, b->desc->output);
    if (result == STP_OK && b->desc->draft != NULL) {
        stp_file_remove_stale(b->context, b->desc->draft);
    }
    b->previous =
        result == STP_OK && !b->desc->fresh ? stp_previous_output_open(b->desc->output) : NULL;
    return result == STP_OK ? stp_spill_create(b->context, b->work_folder, &b->spill) : result;
}

static bool is_generated(const build* b, const char* input)
{
    static const char prefix[] = "scene:";
    return b->desc->generate != NULL && strncmp(input, prefix, sizeof(prefix) - 1) == 0;
}

static stp_import_desc import_desc_of(const build* b)
{
    stp_import_desc import = b->desc->import;
    if (import.helper_memory_bytes == 0) { // a helper process needs as much again
        import.helper_memory_bytes = limit_bytes(b);
    }
    return import;
}

// Methods that find signs need whole surfaces, not pieces of them.
static stp_result partition_scene(build* b)
{
    stp_partition_desc partition = b->desc->partition;
    for (uint32_t i = 0; i < b->desc->method_count; ++i) {
        partition.finds_signs = partition.finds_signs || b->desc->methods[i]->finds_signs;
    }
    return stp_scene_partition(b->scene, &partition);
}

// Shows a sample of a large scan in the draft before the scan is read.
static stp_result preview_sample(build* b)
{
    stp_scene* scene = NULL;
    stp_import_desc import = import_desc_of(b);
    if (b->draft == NULL || b->desc->input_count != 1 || is_generated(b, b->desc->inputs[0])) {
        return STP_OK;
    }
    uint32_t points = b->desc->draft_sample != 0 ? b->desc->draft_sample : SAMPLE_POINTS;
    stp_result result = stp_scene_create(b->context, &scene);
    if (result == STP_OK) {
        result = stp_import_sample(scene, b->desc->inputs[0], &import, points);
    }
    if (result == STP_OK && scene->point_set_count > 0) {
        result = stp_scene_finish(scene);
        if (result == STP_OK) {
            stp_build_draft_preview(b->draft, scene);
        }
    }
    stp_scene_destroy(scene);
    return result;
}

/// Number of triangles and points.
static uint64_t count_elements(const stp_scene* scene)
{
    uint64_t count = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        count += scene->meshes[i].triangle_count;
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        count += scene->point_sets[i].point_count;
    }
    return count;
}

static stp_result import_input(build* b, const char* input)
{
    if (is_generated(b, input)) {
        return b->desc->generate(b->scene, input, b->desc->generate_user);
    }
    stp_import_desc import = import_desc_of(b);
    return stp_import_file(b->scene, input, &import);
}

static stp_result import_inputs(build* b)
{
    double start = stp_clock_ms();
    stp_result result = preview_sample(b);
    result = result == STP_OK ? stp_scene_create(b->context, &b->scene) : result;
    if (result == STP_OK) {
        stp_scene_use_spill(b->scene, b->spill, usable_bytes(b) / FILE_MEMORY_SHARE);
    }
    for (size_t i = 0; result == STP_OK && i < b->desc->input_count; ++i) {
        uint64_t before = count_elements(b->scene);
        result = import_input(b, b->desc->inputs[i]);
        if (result == STP_OK && count_elements(b->scene) == before) {
            stp_warn(b->context, "%s: has neither triangles nor points", b->desc->inputs[i]);
        }
    }
    stp_trim_heap(); // parsing leaves many small holes
    double imported = stp_clock_ms();
    b->report->import_s = (imported - start) * 1e-3;
    result = result == STP_OK ? stp_progress(b->context, "partition", 0.0) : result;
    result = result == STP_OK ? stp_scene_finish(b->scene) : result;
    stp_spill_release_pages(b->spill); // all was read, to be hashed
    result = result == STP_OK ? stp_build_encode_textures(b->scene) : result;
    result = result == STP_OK ? stp_build_census(b->scene, &b->census) : result;
    if (result == STP_OK) {
        stp_build_draft_preview(b->draft, b->scene);
    }
    stp_spill_release_pages(b->spill);
    result = result == STP_OK ? stp_progress(b->context, "partition", 0.5) : result;
    result = result == STP_OK ? partition_scene(b) : result;
    stp_spill_release_pages(b->spill);
    stp_trim_heap();
    b->report->partition_s = (stp_clock_ms() - imported) * 1e-3;
    return result;
}

// Splits the wall time of splat sets in proportion to the threads' time per phase.
static void report_splat_sets(build* b, double seconds)
{
    const stp_build_nodes* nodes = &b->nodes;
    double all_ms = nodes->capture_ms + nodes->order_ms + nodes->finish_ms;
    double share = all_ms > 0.0 ? seconds / all_ms : 0.0;
    b->report->capture_s = nodes->capture_ms * share;
    b->report->order_s = nodes->order_ms * share;
    b->report->finish_s = nodes->finish_ms * share;
    b->report->splat_thread_s = all_ms * 1e-3;
    b->report->candidates = nodes->candidates;
    b->report->sets_made = nodes->made;
    b->report->sets_found = nodes->found;
}

static uint64_t choose_threshold(build* b)
{
    const stp_build_desc* desc = b->desc;
    bool wanted =
        desc->wants_splats == NULL || desc->wants_splats(b->scene, desc->wants_splats_user);
    b->splats_wanted = wanted;
    return !wanted                ? STP_BUILD_NO_SPLATS
           : desc->threshold != 0 ? desc->threshold
                                  : STP_BUILD_DEFAULT_THRESHOLD;
}

static uint64_t largest_step(const stp_build_plan* plan)
{
    uint64_t maximum = 0;
    for (uint32_t i = 0; i < plan->step_count; ++i) {
        maximum = plan->steps[i].bytes > maximum ? plan->steps[i].bytes : maximum;
    }
    return maximum;
}

/// Whether the file holds the method whose splats name their growths.
static bool has_blue(const stp_build_desc* desc)
{
    bool has = desc->method_count == 0;
    for (uint32_t i = 0; i < desc->method_count; ++i) {
        has = has || desc->methods[i] == &stp_methods[0];
    }
    return has;
}

// The only method, if it needs no samples; else NULL.
static const stp_method* method_alone(const stp_build_desc* desc)
{
    const stp_method* only = desc->method_count == 1 ? desc->methods[0] : NULL;
    return only != NULL && only->make_alone != NULL ? only : NULL;
}

static stp_result plan_splat_sets(build* b)
{
    const stp_build_desc* desc = b->desc;
    stp_result result = stp_scene_find_looks(b->scene);
    bool grow = desc->method_count == 0 || method_alone(desc) == NULL; // surfels are made
    result = result == STP_OK ? stp_make_shadings(b->scene, grow, &b->shadings) : result;
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < b->shadings.count; ++i) {
        b->scene->front_only_shadings[i] =
            (b->shadings.shadings[i].flags & STP_SHADING_FRONT_ONLY) != 0;
    }
    b->blue = desc->blue;
    b->blue.growths = b->shadings.has_growths ? &b->shadings.growths : NULL;
    stp_build_plan_desc plan = {
        .blue = &b->blue,
        .rule = desc->splat_rule,
        .shading_of_material = b->shadings.of_material,
        .shadings = b->shadings.shadings,
        .threshold = choose_threshold(b),
        .from_triangles = desc->from_triangles,
    };
    result = stp_build_plan_make(b->scene, &plan, &b->plan);
    if (result == STP_OK) {
        stp_build_draft_begin(b->draft, b->scene, &b->plan, &b->shadings, &b->census);
    }
    return result;
}

static stp_result make_splat_sets(build* b)
{
    const stp_build_desc* desc = b->desc;
    double start = stp_clock_ms();
    stp_build_nodes_desc nodes = {
        .plan = &b->plan,
        .blue = &b->blue,
        .method = method_alone(desc),
        .options = &desc->method_options,
        .shading_of_material = b->shadings.of_material,
        .shading_count = b->shadings.count,
        .from_triangles = desc->from_triangles,
        .memory_bytes = bytes_for_step(b),
        .work = b->work,
        .previous = b->previous,
        .draft = b->draft,
    };
    stp_context_expect_bytes(b->context,
                             stp_context_live_bytes(b->context) + largest_step(&b->plan));
    stp_result result = stp_build_nodes_make(b->scene, &nodes, &b->nodes);
    stp_context_expect_bytes(b->context, 0);
    stp_work_release_pages(b->work);
    if (result == STP_OK) {
        report_splat_sets(b, (stp_clock_ms() - start) * 1e-3);
    }
    return result;
}

// Whether coarse ellipses are made beside the sets of `blue`.
static bool makes_coarse(const stp_build_desc* desc)
{
    return desc->coarse &&
           (desc->method_count == 0 || stp_methods_want_coarse(desc->methods, desc->method_count));
}

static stp_result make_methods(build* b)
{
    static const stp_method* const only_blue[] = {&stp_methods[0]};
    const stp_build_desc* desc = b->desc;
    double start = stp_clock_ms();
    stp_build_methods_desc methods = {
        .plan = &b->plan,
        .samples = b->nodes.sets,
        .alone = method_alone(desc),
        .methods = desc->method_count != 0 ? desc->methods : only_blue,
        .method_count = desc->method_count != 0 ? desc->method_count : 1,
        .coarse = makes_coarse(desc) ? &stp_method_coarse : NULL,
        .options = &desc->method_options,
        .shading_count = b->shadings.count,
        .shadings = b->shadings.shadings,
        .growths = b->blue.growths,
        .memory_bytes = bytes_for_step(b),
        .work = b->work,
        .previous = b->previous,
    };
    stp_result result = stp_build_methods_make(b->scene, &methods, &b->methods);
    stp_work_release_pages(b->work);
    b->report->methods_s = (stp_clock_ms() - start) * 1e-3;
    b->report->sets_made += b->methods.made;
    b->report->sets_found += b->methods.found;
    return result;
}

static stp_result code_meshes(build* b)
{
    double start = stp_clock_ms();
    stp_result result = stp_build_meshes_make(b->scene, b->work, b->previous, b->draft, &b->meshes);
    stp_work_release_pages(b->work);
    b->report->clusters_s = (stp_clock_ms() - start) * 1e-3;
    b->report->meshes_made = b->meshes.made;
    b->report->meshes_found = b->meshes.found;
    return result;
}

static stp_result make_levels(build* b)
{
    double start = stp_clock_ms();
    if (!b->splats_wanted || b->desc->no_levels || !has_blue(b->desc)) {
        return STP_OK;
    }
    stp_build_levels_desc levels = {
        .shading_of_material = b->shadings.of_material,
        .shadings = b->shadings.shadings,
        .shading_count = b->shadings.count,
        .memory_bytes = bytes_for_step(b),
        .work = b->work,
        .previous = b->previous,
    };
    stp_result result = stp_build_levels_make(b->scene, &levels, &b->levels);
    stp_work_release_pages(b->work);
    b->report->levels_s = (stp_clock_ms() - start) * 1e-3;
    b->report->levels_made = b->levels.made;
    b->report->levels_found = b->levels.found;
    return result;
}

static void release_pages(void* user)
{
    const build* b = user;
    stp_work_release_pages(b->work);
    if (b->spill != NULL) {
        stp_spill_release_pages(b->spill); // attributes of points
    }
}

static bool is_intact(void* user)
{
    const build* b = user;
    return stp_work_is_intact(b->work);
}

static stp_result make_content(build* b)
{
    assert(b->methods.set_count >= b->plan.step_count &&
           "the first method has a set for each step");
    stp_result result = stp_build_content_create(b->scene, b->methods.sets, b->methods.set_count,
                                                 b->plan.step_of, &b->levels, &b->content);
    if (result == STP_OK) {
        stp_store_content* content = &b->content.content;
        content->census = &b->census;
        result = stp_build_content_add_meshes(&b->content, b->scene, &b->meshes, &b->levels);
        content->set_keys = b->methods.keys;
        content->directory.methods = b->methods.methods;
        content->directory.method_count = b->methods.method_count;
        content->release_pages = release_pages;
        content->is_intact = is_intact;
        content->release_user = b;
        bool grown = has_blue(b->desc); // else no splat of the file names a growth
        for (uint32_t i = 0; i < b->shadings.count && !grown; ++i) {
            b->shadings.shadings[i].growth = 0.0f;
        }
        content->directory.shadings = b->shadings.shadings;
        content->directory.shading_count = b->shadings.count;
        content->directory.build_json = b->desc->parameters_json;
        result =
            result == STP_OK ? stp_build_note_certainty(b->scene, content, &b->methods) : result;
    }
    return result;
}

static stp_result write_file(build* b)
{
    double start = stp_clock_ms();
    stp_result result = stp_progress(b->context, "write", 0.0);
    result = result == STP_OK ? make_content(b) : result;
    result = result == STP_OK ? stp_store_write(b->context, &b->content.content, b->desc->output)
                              : result;
    if (result == STP_OK) {
        (void)!stp_progress(b->context, "write", 1.0); // it is too late to stop
    }
    b->report->write_s = (stp_clock_ms() - start) * 1e-3;
    return result;
}

// Removes the work folder if the output is written, if the folder holds no result, or if a result
// has changed, because other results may derive from it. @return whether a result has changed
static bool close_build(build* b, bool written)
{
    stp_work_report kept = {0};
    bool changed = b->work != NULL && !written && !stp_work_is_intact(b->work);
    if (b->work != NULL) {
        stp_work_get_report(b->work, &kept);
        b->report->work_bytes = kept.stored_bytes + kept.found_bytes;
    }
    stp_build_draft_destroy(b->draft);
    stp_build_content_destroy(&b->content);
    stp_build_methods_destroy(b->context, &b->methods);
    stp_build_meshes_destroy(b->context, &b->meshes);
    stp_build_levels_destroy(b->context, &b->levels);
    stp_build_nodes_destroy(b->context, &b->nodes);
    stp_build_plan_destroy(b->context, &b->plan);
    stp_store_census_destroy(b->context, &b->census);
    stp_free(b->context, b->shadings.of_material);
    stp_scene_destroy(b->scene);
    stp_spill_destroy(b->spill);
    stp_previous_output_close(b->previous);
    stp_work_close(b->work, written || changed || kept.held == 0);
    stp_free(b->context, b->work_folder);
    return changed;
}

// With drafts, triangles come first: they are quick to make and show the whole scene.
static stp_result make_parts(build* b)
{
    stp_result result = plan_splat_sets(b);
    if (b->draft == NULL) {
        result = result == STP_OK ? make_splat_sets(b) : result;
        result = result == STP_OK ? make_methods(b) : result;
        result = result == STP_OK ? make_levels(b) : result;
        return result == STP_OK ? code_meshes(b) : result;
    }
    result = result == STP_OK ? code_meshes(b) : result;
    if (result == STP_OK && b->plan.step_count > 0) {
        stp_build_draft_write(b->draft);
    }
    result = result == STP_OK ? make_splat_sets(b) : result;
    result = result == STP_OK ? make_methods(b) : result;
    return result == STP_OK ? make_levels(b) : result;
}

// Whether sets of methods other than `blue` are derived from its samples.
static bool derives_sets(const stp_build_desc* desc)
{
    bool derives = false;
    for (uint32_t i = 0; i < desc->method_count; ++i) {
        derives = derives || desc->methods[i]->make != NULL;
    }
    return derives && method_alone(desc) == NULL;
}

static void plan_stages(build* b)
{
    const stp_build_desc* desc = b->desc;
    stp_stage* stages = b->stages;
    static const stp_stage import = {"import", 5.0}, partition = {"partition", 3.0},
                           splats = {"surfels", 80.0}, methods = {"methods", 8.0},
                           coarse = {"methods", 1.0}, levels = {"levels", 30.0},
                           clusters = {"clusters", 6.0}, write = {"write", 6.0};
    size_t count = 0;
    stages[count++] = import;
    stages[count++] = partition;
    if (desc->draft != NULL) {
        stages[count++] = clusters;
    }
    stages[count++] = splats;
    if (derives_sets(desc)) {
        stages[count++] = methods;
    } else if (makes_coarse(desc)) {
        stages[count++] = coarse;
    }
    if (has_blue(desc) && !desc->no_levels) {
        stages[count++] = levels;
    }
    if (desc->draft == NULL) {
        stages[count++] = clusters;
    }
    stages[count++] = write;
    assert(count <= STAGES);
    stp_progress_plan(b->context, stages, count);
}

// @param changed  whether another process changed a stored result
static stp_result build_once(stp_context* context, const stp_build_desc* desc,
                             stp_build_report* report, bool* changed)
{
    *report = (stp_build_report){0};
    build b = {.context = context, .desc = desc, .report = report};
    plan_stages(&b);
    b.draft = method_alone(desc) == NULL ? stp_build_draft_create(context, desc) : NULL;
    stp_result result = try_output(context, desc->output);
    result = result == STP_OK ? open_work(&b) : result;
    result = result == STP_OK ? import_inputs(&b) : result;
    result = result == STP_OK ? make_parts(&b) : result;
    bool intact = result != STP_OK || stp_work_is_intact(b.work);
    result = result == STP_OK && intact ? write_file(&b) : result;
    *changed = close_build(&b, result == STP_OK && intact);
    stp_progress_plan(context, NULL, 0);
    return *changed && result == STP_OK ? STP_ERROR_IO : result;
}

stp_result stp_build(stp_context* context, const stp_build_desc* desc, stp_build_report* report)
{
    stp_build_report unwanted;
    report = report != NULL ? report : &unwanted;
    double start = stp_clock_ms();
    bool changed = false;
    stp_hold_errors(context); // several threads may fail: the first error is logged
    stp_result result = build_once(context, desc, report, &changed);
    if (changed && result != STP_ERROR_CANCELLED) {
        stp_warn(context, "%s.work: another process changed results of the build; starting again",
                 desc->output);
        stp_hold_errors(context);
        result = build_once(context, desc, report, &changed);
        if (changed) {
            stp_hold_errors(context);
            result = stp_fail(context, STP_ERROR_IO,
                              "%s.work: another process keeps changing results of the build",
                              desc->output);
        }
    }
    stp_release_errors(context, result != STP_OK);
    report->total_s = (stp_clock_ms() - start) * 1e-3;
    return result;
}
