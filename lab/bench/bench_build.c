// SPDX-License-Identifier: MIT
// Benchmark of complete builds of growing scenes: whether the time is proportional to the
// triangles, how much memory a build takes, and the size of the file.
#include "builder/build_scene.h"
#include "lab/bench/bench.h"
#include "lab/scenes/scenes.h"
#include "program/options/program.h"
#include "store/file/store.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct build_case {
    const char* scene;
    double scale;
} build_case;

typedef struct built {
    stp_build_report report;
    uint64_t triangles, unique_triangles, splats, file_bytes, splat_bytes, triangle_bytes;
    uint64_t peak_bytes;
    uint32_t threads;
} built;

/// A temporary folder for builds, removed after the run.
typedef struct bench_folder {
    char path[512], file[560];
} bench_folder;

static bool make_folder(bench_folder* folder)
{
    const char* base = getenv("TMPDIR");
    snprintf(folder->path, sizeof(folder->path), "%s/stipple-bench-XXXXXX",
             base != NULL && *base != '\0' ? base : "/tmp");
    if (mkdtemp(folder->path) == NULL) {
        tool_error("%s: cannot be created: %s", folder->path, strerror(errno));
        return false;
    }
    snprintf(folder->file, sizeof(folder->file), "%s/bench.stip", folder->path);
    return true;
}

static void remove_folder(const bench_folder* folder)
{
    (void)unlink(folder->file);
    (void)rmdir(folder->path); // fails if an unsuccessful build left results in bench.stip.work
}

static stp_result read_file(stp_context* context, const char* path, built* out)
{
    stp_store* store = NULL;
    stp_store_open_desc desc = {.summary_only = true};
    stp_result result = stp_store_open_with(context, path, &desc, &store);
    if (result != STP_OK) {
        return result;
    }
    const stp_store_summary* summary = stp_store_get_summary(store);
    out->triangles = summary->figures.triangles;
    out->unique_triangles = summary->figures.unique_triangles;
    out->splats = summary->figures.unique_surfels;
    out->splat_bytes = summary->figures.splat_bytes;
    out->triangle_bytes = summary->figures.triangle_bytes;
    out->file_bytes = stp_store_file_bytes(store);
    stp_store_close(store);
    return STP_OK;
}

/// Builds an input from scratch. `threads` 0: all.
static bool build_once(const char* input, uint32_t threads, const bench_folder* folder, built* out)
{
    stp_context* context = tool_context_create(threads, 0, "none");
    if (context == NULL) {
        return false;
    }
    *out = (built){.threads = stp_context_thread_count(context)};
    stp_build_desc desc = {.inputs = &input,
                           .input_count = 1,
                           .output = folder->file,
                           .generate = scene_make_input,
                           .fresh = true,
                           .parameters_json = "{}"};
    stp_result result = stp_build(context, &desc, &out->report);
    out->peak_bytes = stp_context_peak_bytes(context);
    result = result == STP_OK ? read_file(context, folder->file, out) : result;
    (void)unlink(folder->file);
    stp_context_destroy(context);
    return result == STP_OK;
}

static double per(double amount, uint64_t count)
{
    return count > 0 ? amount / (double)count : 0.0;
}

static void report_build(const char* scene, double scale, const built* b, json_t* results)
{
    const stp_build_report* r = &b->report;
    bench_entry entry = bench_result(results, "build");
    bench_set_text(entry.params, "scene", scene);
    bench_set_number(entry.params, "scale", scale);
    bench_set_count(entry.params, "threads", b->threads);
    bench_set_count(entry.figures, "triangles", b->unique_triangles);
    bench_set_count(entry.figures, "instanced_triangles", b->triangles);
    bench_set_number(entry.figures, "seconds", r->total_s);
    bench_set_number(entry.figures, "triangles_per_second",
                     (double)b->unique_triangles / r->total_s);
    bench_set_number(entry.figures, "seconds_per_million_triangles",
                     per(1e6 * r->total_s, b->unique_triangles));
    bench_set_count(entry.figures, "peak_bytes", b->peak_bytes);
    bench_set_number(entry.figures, "import_seconds", r->import_s);
    bench_set_number(entry.figures, "partition_seconds", r->partition_s);
    bench_set_number(entry.figures, "capture_seconds", r->capture_s);
    bench_set_number(entry.figures, "order_seconds", r->order_s);
    bench_set_number(entry.figures, "finish_seconds", r->finish_s);
    bench_set_number(entry.figures, "levels_seconds", r->levels_s);
    bench_set_number(entry.figures, "clusters_seconds", r->clusters_s);
    bench_set_number(entry.figures, "write_seconds", r->write_s);
    bench_set_count(entry.figures, "candidates", r->candidates);
    bench_set_count(entry.figures, "surfel_sets", r->sets_made);
    bench_set_count(entry.figures, "surfels", b->splats);
    bench_set_count(entry.figures, "file_bytes", b->file_bytes);
    bench_set_number(entry.figures, "bytes_per_surfel", per((double)b->splat_bytes, b->splats));
    bench_set_number(entry.figures, "bytes_per_triangle",
                     per((double)b->triangle_bytes, b->unique_triangles));
}

static bool measure_case(const build_case* c, const bench_folder* folder, json_t* results)
{
    char input[96];
    snprintf(input, sizeof(input), SCENE_PREFIX "%s,scale=%.17g", c->scene, c->scale);
    built b;
    if (!build_once(input, 0, folder, &b)) {
        return false;
    }
    report_build(c->scene, c->scale, &b, results);
    return true;
}

/// Speedup by a second thread, from alternating builds with one and two.
static bool measure_threads(const build_case* c, size_t repeats, const bench_folder* folder,
                            json_t* results)
{
    enum { MOST = 3 };
    double one[MOST], two[MOST];
    char input[96];
    snprintf(input, sizeof(input), SCENE_PREFIX "%s,scale=%.17g", c->scene, c->scale);
    repeats = repeats < MOST ? repeats : MOST;
    for (size_t i = 0; i < repeats; ++i) {
        built b;
        if (!build_once(input, 1, folder, &b)) {
            return false;
        }
        one[i] = b.report.total_s;
        if (!build_once(input, 2, folder, &b)) {
            return false;
        }
        two[i] = b.report.total_s;
    }
    bench_entry entry = bench_result(results, "build threads");
    bench_set_text(entry.params, "scene", c->scene);
    bench_set_number(entry.params, "scale", c->scale);
    double single = bench_median(one, repeats), both = bench_median(two, repeats);
    bench_set_number(entry.figures, "seconds_1_thread", single);
    bench_set_number(entry.figures, "seconds_2_threads", both);
    bench_set_number(entry.figures, "speed_up", both > 0.0 ? single / both : 0.0);
    return true;
}

static bool measure_row(bool quick, const bench_folder* folder, json_t* results)
{
    static const build_case quick_cases[] = {{"one-mesh", 0.01}, {"one-mesh", 0.04}};
    static const build_case full_cases[] = {
        {"one-mesh", 1.0},     {"one-mesh", 4.0}, {"one-mesh", 16.0}, {"paper", 1.0 / 64.0},
        {"paper", 1.0 / 16.0}, {"paper", 0.25},   {"paper", 1.0}};
    static const build_case quick_threads = {"one-mesh", 0.04}, full_threads = {"one-mesh", 4.0};
    const build_case* cases = quick ? quick_cases : full_cases;
    size_t count = quick ? sizeof(quick_cases) / sizeof(quick_cases[0])
                         : sizeof(full_cases) / sizeof(full_cases[0]);
    for (size_t i = 0; i < count; ++i) {
        if (!measure_case(&cases[i], folder, results)) {
            return false;
        }
    }
    return measure_threads(quick ? &quick_threads : &full_threads, quick ? 1 : 3, folder, results);
}

static int run_build(const bench_options* options, json_t* results)
{
    bench_folder folder;
    if (!make_folder(&folder)) {
        return 1;
    }
    bool done;
    if (options->model != NULL) {
        built b;
        done = build_once(options->model, 0, &folder, &b);
        if (done) {
            report_build(options->model, 1.0, &b, results);
        }
    } else {
        done = measure_row(options->quick, &folder, results);
    }
    remove_folder(&folder);
    return done ? 0 : 1;
}

const benchmark benchmark_build = {
    .name = "build",
    .summary = "complete builds from 1 M to 86 M unique triangles; takes minutes",
    .run = run_build,
};
