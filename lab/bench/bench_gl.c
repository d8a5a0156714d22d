// SPDX-License-Identifier: MIT
//
// Benchmark `gl`: the views of a scene drawn by each OpenGL path, at common display sizes and for
// two eyes; times come from the GPU's own timers. --markdown also writes them as a table.
#include "base/core/clock.h"
#include "builder/build_scene.h"
#include "draw/draw_gl.h"
#include "lab/bench/bench.h"
#include "lab/bench/memory_speed.h"
#include "lab/measure/measured_views.h"
#include "lab/scenes/scenes.h"
#include "program/drawing/frame.h"
#include "program/files/scene_file.h"
#include "program/present/headless.h"
#include "select/camera.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { MAX_VIEWS = 5, QUICK_VIEWS = 2, REPEATS = 9, QUICK_REPEATS = 3, WARM = 2 };
static const uint64_t splat_bytes = 12; ///< bytes read per splat: place, normal, colour, coverage
static const uint64_t copied_bytes = UINT64_C(256) << 20, quick_copied_bytes = UINT64_C(8) << 20;
static const double geometry_max_ms = 90000.0; ///< full geometry is skipped after this total time
static const uint64_t hardware_memory = UINT64_C(12) << 30, software_memory = UINT64_C(2) << 30;

typedef struct picture_size {
    uint32_t width, height;
    bool stereo;
    const char* name;
} picture_size;

static const picture_size sizes[] = {
    {1920, 1080, false, "1080p"},
    {2560, 1440, false, "1440p"},
    {3840, 2160, false, "4K"},
    {2 * 1344, 1600, true, "2 x 1344 x 1600"},
};
static const picture_size quick_sizes[] = {
    {320, 180, false, "320x180"},
    {2 * 112, 134, true, "2 x 112 x 134"},
};

typedef struct draw_path {
    const char* name;
    stp_gl_splats splats;
    bool reference;
} draw_path;

static const draw_path ways[] = {
    {"points", STP_GL_SPLATS_POINTS, false},
    {"compute", STP_GL_SPLATS_COMPUTE, false},
    {"auto", STP_GL_SPLATS_AUTO, false},
    {"full geometry", STP_GL_SPLATS_POINTS, true},
};
enum { WAYS = sizeof(ways) / sizeof(ways[0]) };

typedef struct gl_bench {
    stp_context* context;
    stp_store* store;
    stp_headless headless;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_image image;
    const char* model;
    const bench_options* options;
    bool small; ///< few small pictures: requested, or drawn by a CPU
    const char* names[MAX_VIEWS];
    uint32_t view_count;
    double copied;      ///< bytes a second, read and written
    double geometry_ms; ///< wall-clock time of full geometry so far
    json_t* results;
    FILE* table; ///< NULL: none is wanted
} gl_bench;

/// Times of one view on one path: medians, and the slowest frame. Counts are the last frame's.
typedef struct frame_times {
    double draw_ms, shade_ms, select_ms, slowest_ms;
    stp_draw_stats stats;
    stp_draw_gl_stats gl;
} frame_times;

static stp_result measure_frames(gl_bench* b, const stp_view* view, const draw_path* w,
                                 frame_times* times)
{
    double draw[REPEATS], shade[REPEATS], select[REPEATS];
    int repeats = b->small || w->reference ? QUICK_REPEATS : REPEATS;
    stp_quality quality = {.splat_size = (float)b->options->splat_size, .reference = w->reference};
    stp_draw_style style = {0};
    stp_result result = STP_OK;
    *times = (frame_times){.draw_ms = 0.0};
    for (int i = -WARM; i < repeats && result == STP_OK; ++i) {
        stp_draw_stats* s = &times->stats;
        result =
            stp_renderer_draw_selected(b->renderer, view, &quality, &style, &b->list, &b->image, s);
        int at = i < 0 ? 0 : i;
        draw[at] = s->draw_ms;
        shade[at] = s->shade_ms;
        select[at] = s->select_ms;
        times->slowest_ms = i < 0 ? 0.0 : fmax(times->slowest_ms, s->draw_ms + s->shade_ms);
    }
    if (result == STP_OK) {
        times->draw_ms = bench_median(draw, (size_t)repeats);
        times->shade_ms = bench_median(shade, (size_t)repeats);
        times->select_ms = bench_median(select, (size_t)repeats);
        times->gl = stp_draw_gl_get_stats(b->renderer);
    }
    return result;
}

static void write_row(const gl_bench* b, const picture_size* size, const char* view,
                      const draw_path* w, const frame_times* t, double rate)
{
    double frame = t->draw_ms + t->shade_ms;
    if (b->table == NULL) {
        return;
    }
    fprintf(b->table,
            "| %s | %s | %s | %.3f | %.3f | %.3f | %.0f | %llu | %llu | %.0f | %.1f %% | %u |\n",
            size->name, view, w->name, frame, t->draw_ms, t->shade_ms,
            frame > 0.0 ? 1000.0 / frame : 0.0, (unsigned long long)t->stats.splats,
            (unsigned long long)t->stats.triangles, rate * 1e-6,
            b->copied > 0.0 ? 100.0 * rate * (double)splat_bytes / b->copied : 0.0,
            t->stats.draw_calls);
}

static void report(gl_bench* b, const picture_size* size, const char* view, const draw_path* w,
                   const frame_times* t)
{
    static const char* const used[] = {"auto", "points", "compute"};
    double rate = t->draw_ms > 0.0 && !w->reference
                      ? (double)t->stats.listed_splats / (t->draw_ms * 1e-3)
                      : 0.0;
    assert((size_t)t->gl.splats < sizeof(used) / sizeof(used[0]) && "every path has a name");
    bench_entry e = bench_result(b->results, "gl");
    bench_set_text(e.params, "model", b->model);
    bench_set_text(e.params, "device", b->headless.device);
    bench_set_text(e.params, "picture", size->name);
    bench_set_count(e.params, "width", size->width);
    bench_set_count(e.params, "height", size->height);
    bench_set_text(e.params, "view", view);
    bench_set_text(e.params, "way", w->name);
    bench_set_text(e.figures, "used", used[t->gl.splats]);
    bench_set_number(e.figures, "frame_ms", t->draw_ms + t->shade_ms);
    bench_set_number(e.figures, "slowest_ms", t->slowest_ms);
    bench_set_number(e.figures, "draw_ms", t->draw_ms);
    bench_set_number(e.figures, "shade_ms", t->shade_ms);
    bench_set_number(e.figures, "select_ms", t->select_ms);
    bench_set_count(e.figures, "splats", t->stats.splats);
    bench_set_count(e.figures, "triangles", t->stats.triangles);
    bench_set_count(e.figures, "fragments", t->stats.fragments);
    bench_set_count(e.figures, "covered_pixels", t->stats.covered_pixels);
    bench_set_count(e.figures, "draw_calls", t->stats.draw_calls);
    bench_set_count(e.figures, "missing", t->gl.missing);
    bench_set_count(e.figures, "resident_bytes", t->gl.resident_bytes);
    bench_set_number(e.figures, "splats_per_second", rate);
    bench_set_number(e.figures, "splat_bytes_per_second", rate * (double)splat_bytes);
    write_row(b, size, view, w, t, rate);
}

/// A path that fails (full geometry may be too much) does not stop the others.
static void report_failure(gl_bench* b, const picture_size* size, const char* view,
                           const draw_path* w, const char* why)
{
    bench_entry e = bench_result(b->results, "gl");
    bench_set_text(e.params, "picture", size->name);
    bench_set_text(e.params, "view", view);
    bench_set_text(e.params, "way", w->name);
    bench_set_text(e.figures, "used", why);
    if (b->table != NULL) {
        fprintf(b->table, "| %s | %s | %s | %s | | | | | | | | |\n", size->name, view, w->name,
                why);
    }
}

static stp_result measure_size(gl_bench* b, const picture_size* size)
{
    const double unit = stp_store_get_directory(b->store)->unit_metres;
    stp_free(b->context, b->image.pixels);
    b->image = (stp_image){0};
    if (!frame_image_create(b->context, size->width, size->height, &b->image)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t v = 0; v < b->view_count; ++v) {
        stp_view view = {.width = size->width, .height = size->height};
        if (!measured_view(b->store, b->names[v], &view)) {
            continue;
        }
        view.fov_degrees = view.fov_degrees > 0.0 ? view.fov_degrees : STP_CAMERA_PLACED_FOV;
        view.eye_distance = size->stereo ? 0.064 / (unit > 0.0 ? unit : 1.0) : 0.0;
        for (int w = 0; w < WAYS; ++w) {
            frame_times times;
            if (ways[w].reference && b->geometry_ms > geometry_max_ms) {
                report_failure(b, size, b->names[v], &ways[w], "skipped: it takes too long");
                continue;
            }
            double start = stp_clock_ms();
            stp_draw_gl_set_splats(b->renderer, ways[w].splats);
            stp_result result = measure_frames(b, &view, &ways[w], &times);
            b->geometry_ms += ways[w].reference ? stp_clock_ms() - start : 0.0;
            if (result == STP_OK) {
                report(b, size, b->names[v], &ways[w], &times);
            } else {
                report_failure(b, size, b->names[v], &ways[w], "cannot be drawn");
            }
        }
    }
    return STP_OK;
}

static void report_device(gl_bench* b)
{
    static const char* const names[2] = {"points", "compute"};
    stp_draw_gl_speed speed = stp_draw_gl_get_speed(b->renderer);
    assert(speed.sizes[0] <= speed.sizes[1] && speed.sizes[1] <= speed.sizes[2]);
    bench_entry e = bench_result(b->results, "gl ways");
    bench_set_text(e.params, "device", b->headless.device);
    bench_set_number(e.figures, "copied_bytes_per_second", b->copied);
    for (int way = 0; way < 2; ++way) {
        if (!(speed.splat_ns[way][0] > 0.0)) {
            continue;
        }
        json_t* figures = json_object();
        for (int i = 0; i < STP_GL_SPLAT_SIZES; ++i) {
            char key[40];
            snprintf(key, sizeof(key), "ns_a_splat_of_%gpx", (double)speed.sizes[i]);
            bench_set_number(figures, key, speed.splat_ns[way][i]);
        }
        bench_set_number(figures, "fixed_ms", speed.fixed_ns[way] * 1e-6);
        json_object_set_new(e.figures, names[way], figures);
        if (b->table != NULL) {
            fprintf(b->table,
                    "%s* %s: %.2f, %.2f, %.2f ns per splat of 1, 3, 8 pixels; %.3f ms regardless "
                    "of the content\n",
                    way == 0 ? "\nMeasured at start:\n\n" : "", names[way], speed.splat_ns[way][0],
                    speed.splat_ns[way][1], speed.splat_ns[way][2], speed.fixed_ns[way] * 1e-6);
        }
    }
}

static void list_views(gl_bench* b)
{
    const stp_store_directory* d = stp_store_get_directory(b->store);
    uint32_t maximum = b->small ? QUICK_VIEWS : MAX_VIEWS;
    for (uint32_t i = 0; i < d->view_count && b->view_count < maximum; ++i) {
        if (d->views[i].name != NULL) {
            b->names[b->view_count++] = d->views[i].name;
        }
    }
    if (b->view_count == 0) {
        b->names[b->view_count++] = "iso";
    }
}

static stp_result measure(gl_bench* b)
{
    const picture_size* all = b->small ? quick_sizes : sizes;
    size_t count =
        b->small ? sizeof(quick_sizes) / sizeof(quick_sizes[0]) : sizeof(sizes) / sizeof(sizes[0]);
    stp_result result = STP_OK;
    list_views(b);
    b->copied = gl_measure_copy(&b->headless, b->small ? quick_copied_bytes : copied_bytes);
    if (b->table != NULL) {
        fprintf(b->table,
                "Device: %s. Scene: %s, splats of %g pixels. Memory: %.1f GB/s (read and written, "
                "copying). Times by the device's timers: medians.\n\n"
                "| picture | view | way | frame ms | draw ms | shade ms | frames/s | splats | "
                "triangles | Msplats/s | of bandwidth | draw calls |\n"
                "|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
                b->headless.device, b->model, b->options->splat_size, b->copied * 1e-9);
    }
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        result = measure_size(b, &all[i]);
    }
    report_device(b);
    return result;
}

/// A part of the benchmark scene, in a temporary file.
static stp_result open_scene(gl_bench* b, const char* path)
{
    if (b->options->model != NULL) {
        b->model = b->options->model;
        return tool_open_scene(b->context, b->options->model, &b->store);
    }
    b->model = b->options->quick ? "scene:paper,scale=0.001" : "scene:paper,scale=0.02";
    stp_build_desc desc = {
        .inputs = &b->model, .input_count = 1, .output = path, .generate = scene_make_input};
    stp_build_report built;
    stp_result result = stp_build(b->context, &desc, &built);
    return result == STP_OK ? stp_store_open(b->context, path, &b->store) : result;
}

static stp_result open_all(gl_bench* b, const char* path)
{
    b->small = b->options->quick || b->headless.is_software;
    stp_result result = open_scene(b, path);
    if (result != STP_OK) {
        return result;
    }
    uint64_t memory = b->headless.is_software ? software_memory : hardware_memory;
    stp_draw_gl_desc desc = {.get_proc_address = stp_headless_get_proc_address,
                             .user = &b->headless,
                             .memory_bytes = b->options->memory > 0 ? b->options->memory : memory};
    return stp_draw_gl_create(b->context, b->store, &desc, &b->renderer);
}

static void close_all(gl_bench* b)
{
    if (b->renderer != NULL) {
        stp_renderer_destroy(b->renderer);
    }
    stp_free(b->context, b->image.pixels);
    stp_draw_list_destroy(b->context, &b->list);
    if (b->store != NULL) {
        stp_store_close(b->store);
    }
    if (b->headless.context != NULL) {
        stp_headless_destroy(&b->headless);
    }
    stp_context_destroy(b->context);
}

static int run_gl(const bench_options* options, json_t* results)
{
    char folder[] = "/tmp/stipple-gl-XXXXXX", path[64];
    gl_bench b = {.context = tool_context_create(options->threads, 0, "none"),
                  .options = options,
                  .results = results};
    if (b.context == NULL) {
        return 1;
    }
    const char* fault = stp_headless_create(&(stp_headless_desc){.software = false}, &b.headless);
    if (fault != NULL) { // others can be measured
        fprintf(stderr, "bench gl: %s; nothing is measured\n", fault);
        stp_context_destroy(b.context);
        return 0;
    }
    if (mkdtemp(folder) == NULL) {
        close_all(&b);
        return tool_error("bench gl: cannot create a temporary folder");
    }
    snprintf(path, sizeof(path), "%s/scene.stip", folder);
    stp_result result = open_all(&b, path);
    if (result == STP_OK && options->markdown != NULL) {
        b.table = fopen(options->markdown, "w");
        if (b.table == NULL) {
            (void)tool_error("%s: cannot be written", options->markdown);
            result = STP_ERROR_IO;
        }
    }
    result = result == STP_OK ? measure(&b) : result;
    if (b.table != NULL && fclose(b.table) != 0) {
        result = STP_ERROR_IO;
    }
    close_all(&b);
    unlink(path);
    rmdir(folder);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_gl = {
    .name = "gl",
    .summary = "OpenGL drawing paths (points, compute, full geometry), timed by the device",
    .run = run_gl,
};
