// SPDX-License-Identifier: MIT
//
// Benchmark `frame`: frame times of a scene's views and of a flight, at one splat size and within a
// budget, with both controllers on the same flight; with --memory data is loaded during drawing.
#include "builder/build_scene.h"
#include "lab/bench/bench.h"
#include "lab/measure/measured_views.h"
#include "lab/scenes/scenes.h"
#include "lod/method.h"
#include "program/drawing/draw_options.h"
#include "program/drawing/flight_report.h"
#include "program/files/scene_file.h"
#include "select/camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { REPEATS = 9, QUICK_REPEATS = 3, MAX_VIEWS = 16, QUICK_VIEWS = 2 };
static const double budget_ms = 33.0, seconds_between = 2.0;

typedef struct frame_bench {
    stp_context* context;
    stp_store* store;
    frame_maker maker;
    stp_image image;
    const char* model;
    const bench_options* options;
    bool quick;
    float splat_size;
    const char* names[MAX_VIEWS];
    stp_view views[MAX_VIEWS];
    uint32_t view_count;
    json_t* results;
} frame_bench;

typedef struct way {
    const char* controller; ///< NULL: no budget
    stp_controller kind;
} way;

static const way ways[] = {
    {NULL, STP_CONTROLLER_PREDICT},
    {"predict", STP_CONTROLLER_PREDICT},
    {"paper", STP_CONTROLLER_PAPER},
};
enum { WAYS = sizeof(ways) / sizeof(ways[0]) };

static bench_entry begin_result(const frame_bench* b, const way* w)
{
    bench_entry entry = bench_result(b->results, "frame");
    bench_set_text(entry.params, "model", b->model);
    bench_set_count(entry.params, "width", b->image.width);
    bench_set_count(entry.params, "height", b->image.height);
    bench_set_count(entry.params, "threads", stp_context_thread_count(b->context));
    if (b->options->memory > 0) {
        bench_set_count(entry.params, "memory_bytes", b->options->memory);
    }
    if (b->options->method != 0) {
        bench_set_text(entry.params, "method", stp_method_by_id(b->options->method)->name);
    }
    if (w->controller != NULL) {
        bench_set_number(entry.params, "budget_ms", budget_ms);
        bench_set_text(entry.params, "controller", w->controller);
    }
    return entry;
}

// The same keys as `render --json` and `fly --json`.
static void set_figures(const frame_bench* b, const bench_entry* entry, json_t* figures)
{
    json_t* drawn = frame_maker_describe(&b->maker, b->image.width, b->image.height);
    json_object_update(entry->figures, drawn);
    json_object_update(entry->figures, figures);
    json_decref(drawn);
    json_decref(figures);
}

static int compare_figures(const void* a, const void* b)
{
    double x = ((const frame_figures*)a)->cost.milliseconds;
    double y = ((const frame_figures*)b)->cost.milliseconds;
    return (x > y) - (x < y);
}

static stp_result measure_view(frame_bench* b, uint32_t view, const way* w)
{
    frame_figures frames[REPEATS];
    int repeats = b->quick ? QUICK_REPEATS : REPEATS;
    stp_quality quality = {.splat_size = b->splat_size, .method = b->options->method};
    stp_budget budget;
    stp_budget_init(&budget, w->kind, budget_ms);
    stp_result result = w->controller != NULL
                            ? frame_settle(&b->maker, &b->views[view], &budget, &quality, &b->image)
                            : STP_OK;
    if (result == STP_OK) { // cold caches
        result = frame_draw_loaded(&b->maker, &b->views[view], &quality, &b->image, &frames[0]);
    }
    for (int i = 0; i < repeats && result == STP_OK; ++i) {
        result = frame_draw(&b->maker, &b->views[view], &quality, &b->image, &frames[i]);
    }
    if (result == STP_OK) {
        qsort(frames, (size_t)repeats, sizeof(frames[0]), compare_figures);
        bench_entry entry = begin_result(b, w);
        bench_set_text(entry.params, "view", b->names[view]);
        set_figures(b, &entry, frame_describe(&frames[repeats / 2]));
        bench_set_count(entry.figures, "resident_bytes", frame_maker_resident_bytes(&b->maker));
    }
    return result;
}

static stp_result measure_flight(frame_bench* b, const way* w)
{
    stp_flight_key keys[MAX_VIEWS];
    for (uint32_t i = 0; i < b->view_count; ++i) {
        const stp_view* v = &b->views[i];
        keys[i] = (stp_flight_key){seconds_between * i, v->eye, v->target, stp_normalized(v->up)};
    }
    stp_flight flight = {
        .fov_degrees = 60.0, .fps = 30.0, .keys = keys, .key_count = b->view_count};
    flight_plan plan = {.flight = &flight,
                        .frame_count = b->quick ? 12 : 0,
                        .view = {.width = b->image.width, .height = b->image.height},
                        .quality = {.splat_size = b->splat_size, .method = b->options->method},
                        .budget_ms = w->controller != NULL ? budget_ms : 0.0,
                        .controller = w->kind};
    flight_record record;
    stp_result result = flight_run(&b->maker, &plan, &record);
    if (result == STP_OK) {
        bench_entry entry = begin_result(b, w);
        bench_set_text(entry.params, "flight", "through the views");
        set_figures(b, &entry, flight_describe(&record));
        bench_set_count(entry.figures, "threads", stp_context_thread_count(b->context));
        if (b->maker.residency != NULL) {
            json_object_set_new(entry.figures, "residency",
                                flight_describe_residency(&record, b->maker.residency));
        }
    }
    flight_record_destroy(b->context, &record);
    return result;
}

// The views of the file; if it has at most one, standard views.
static void list_views(frame_bench* b)
{
    static const char* const usual[] = {"front", "iso", "right"};
    const stp_store_directory* directory = stp_store_get_directory(b->store);
    const char* names[MAX_VIEWS];
    uint32_t count = 0, maximum = b->quick ? QUICK_VIEWS : MAX_VIEWS;
    for (uint32_t i = 0; i < directory->view_count && count < maximum; ++i) {
        if (directory->views[i].name != NULL) {
            names[count++] = directory->views[i].name;
        }
    }
    if (count < 2) {
        count = sizeof(usual) / sizeof(usual[0]);
        memcpy(names, usual, sizeof(usual));
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_view view = {.width = b->image.width, .height = b->image.height};
        if (measured_view(b->store, names[i], &view)) {
            view.fov_degrees = view.fov_degrees > 0.0 ? view.fov_degrees : STP_CAMERA_PLACED_FOV;
            b->names[b->view_count] = names[i];
            b->views[b->view_count++] = view;
        }
    }
}

// With a memory limit, a new maker starts with the coarsest data only.
static stp_result recreate_maker(frame_bench* b)
{
    stp_draw_style style = {.transparency = STP_TRANSPARENCY_NEAREST};
    frame_maker_destroy(&b->maker);
    stp_result result = frame_maker_create(b->context, b->store, &style, &b->maker);
    return result == STP_OK && b->options->memory > 0 ? frame_maker_stream(&b->maker) : result;
}

static stp_result measure(frame_bench* b)
{
    uint32_t width = b->quick ? 320 : 1920, height = b->quick ? 180 : 1080;
    if (b->options->size[0] > 0) {
        width = b->options->size[0];
        height = b->options->size[1];
    }
    if (!frame_image_create(b->context, width, height, &b->image)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_result result = recreate_maker(b);
    list_views(b);
    for (uint32_t i = 0; i < b->view_count && result == STP_OK; ++i) {
        for (int w = 0; w < 2 && result == STP_OK; ++w) {
            result = measure_view(b, i, &ways[w]);
        }
    }
    for (int w = 0; w < WAYS && result == STP_OK; ++w) {
        result = b->options->memory > 0 ? recreate_maker(b) : STP_OK;
        if (result == STP_OK) {
            result = measure_flight(b, &ways[w]);
        }
    }
    return result;
}

// A small part of the benchmark scene, in a temporary file.
static stp_result build_default(frame_bench* b, const char* path)
{
    b->model = b->quick ? "scene:paper,scale=0.001" : "scene:paper,scale=0.02";
    const stp_method* method = stp_method_by_id(b->options->method);
    stp_build_desc desc = {.inputs = &b->model,
                           .input_count = 1,
                           .output = path,
                           .methods = &method,
                           .method_count = method != NULL ? 1 : 0,
                           .method_options = stp_method_options_default(),
                           .generate = scene_make_input};
    stp_build_report report;
    stp_result result = stp_build(b->context, &desc, &report);
    return result == STP_OK ? stp_store_open(b->context, path, &b->store) : result;
}

static int run_frame(const bench_options* options, json_t* results)
{
    char folder[] = "/tmp/stipple-frame-XXXXXX", path[64];
    if (mkdtemp(folder) == NULL) {
        return tool_error("bench frame: cannot create a temporary folder");
    }
    snprintf(path, sizeof(path), "%s/scene.stip", folder);
    frame_bench b = {.context = tool_context_create(options->threads, options->memory, "none"),
                     .model = options->model,
                     .options = options,
                     .splat_size = (float)options->splat_size,
                     .quick = options->quick,
                     .results = results};
    stp_result result = STP_ERROR_OUT_OF_MEMORY;
    if (b.context != NULL) {
        result = options->model != NULL
                     ? tool_open_scene_for(b.context, options->model,
                                           scene_use_of_method(options->method), &b.store)
                     : build_default(&b, path);
    }
    if (result == STP_OK && tool_check_method(options->method, b.store, b.model) != 0) {
        result = STP_ERROR_ARGUMENT;
    }
    if (result == STP_OK) {
        result = measure(&b);
    }
    if (b.context != NULL) {
        stp_free(b.context, b.image.pixels);
        frame_maker_destroy(&b.maker);
        if (b.store != NULL) {
            stp_store_close(b.store);
        }
        stp_context_destroy(b.context);
    }
    unlink(path);
    rmdir(folder);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_frame = {
    .name = "frame",
    .summary = "frame times of a scene's views and of a flight, at a splat size and within 33 ms",
    .run = run_frame,
};
