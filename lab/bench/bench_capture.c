// SPDX-License-Identifier: MIT
// Benchmark of capture, and Table 2 of Brandt et al. 2019: renders a model from eight sides, makes
// candidates of the visible surface, and orders 10k, 50k and 100k of them.
#include "capture/capture.h"
#include "lab/bench/bench.h"
#include "lab/bench/memory_speed.h"

#include <stipple/order.h>

#include <stdio.h>
#include <string.h>

enum { REPEATS = 5, COUNTS = 3 };

static const uint32_t counts[COUNTS] = {10000, 50000, 100000};

/// Times of one round, milliseconds.
typedef struct lap {
    double render, create, filled, order[COUNTS]; ///< `filled`: all of a capture with its fill
    uint64_t triangle_views;
    uint32_t candidates, views, resolution;
} lap;

static stp_result order_candidates(stp_context* context, const stp_candidates* candidates, lap* out)
{
    uint32_t* order = STP_NEW_ARRAY(context, uint32_t, counts[COUNTS - 1]);
    stp_result result = order != NULL ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
    for (int i = 0; i < COUNTS && result == STP_OK; ++i) {
        stp_order_desc desc = {.kind = STP_ORDER_EXACT};
        stp_order_report report = {0};
        uint32_t ordered;
        result =
            stp_order_points(context, &desc, candidates->positions, candidates->normals,
                             candidates->count, counts[i], order, NULL, &ordered, NULL, &report);
        out->order[i] = report.index_ms + report.order_ms;
    }
    stp_free(context, order);
    return result;
}

static stp_result run_round(const stp_scene* scene, const stp_placed_part* parts, size_t part_count,
                            const stp_capture_desc* desc, lap* out)
{
    stp_candidates candidates;
    stp_result result = stp_capture_parts(scene, parts, part_count, desc, &candidates);
    if (result != STP_OK) {
        return result;
    }
    *out = (lap){
        .render = candidates.raster_ms,
        .create = candidates.resolve_ms,
        .triangle_views = candidates.triangle_views,
        .candidates = candidates.count,
        .views = candidates.direction_count,
        .resolution = candidates.resolution,
    };
    result = order_candidates(scene->context, &candidates, out);
    stp_candidates_destroy(scene->context, &candidates);
    stp_capture_desc with_fill = *desc;
    with_fill.no_fill = false;
    if (result == STP_OK) {
        result = stp_capture_parts(scene, parts, part_count, &with_fill, &candidates);
    }
    if (result == STP_OK) {
        out->filled = candidates.raster_ms + candidates.resolve_ms;
        stp_candidates_destroy(scene->context, &candidates);
    }
    return result;
}

static void report(const lap* rounds, uint32_t threads, json_t* results)
{
    double render[REPEATS], create[REPEATS], filled[REPEATS], ratio[REPEATS];
    double order[COUNTS][REPEATS];
    for (int i = 0; i < REPEATS; ++i) {
        render[i] = rounds[i].render;
        create[i] = rounds[i].create;
        filled[i] = rounds[i].filled;
        ratio[i] = filled[i] / (render[i] + create[i]);
        for (int k = 0; k < COUNTS; ++k) {
            order[k][i] = rounds[i].order[k];
        }
    }
    double render_ms = bench_median(render, REPEATS);
    double rate = (double)rounds[0].triangle_views / render_ms * 1000.0;
    bench_entry entry = bench_result(results, "capture");
    bench_set_count(entry.params, "triangles", rounds[0].triangle_views / rounds[0].views);
    bench_set_count(entry.params, "resolution", rounds[0].resolution);
    bench_set_count(entry.params, "threads", threads);
    bench_set_number(entry.figures, "triangle_views_per_second", rate);
    bench_set_number(entry.figures, "per_core", rate / (double)threads);
    bench_set_count(entry.figures, "views", rounds[0].views);
    bench_set_count(entry.figures, "candidates", rounds[0].candidates);
    bench_set_number(entry.figures, "render_ms", render_ms);
    bench_set_number(entry.figures, "create_ms", bench_median(create, REPEATS));
    bench_set_number(entry.figures, "with_fill_ms", bench_median(filled, REPEATS));
    bench_set_number(entry.figures, "with_fill_ratio", bench_median(ratio, REPEATS));
    for (int k = 0; k < COUNTS; ++k) {
        char key[32];
        snprintf(key, sizeof(key), "order_%uk_ms", counts[k] / 1000);
        bench_set_number(entry.figures, key, bench_median(order[k], REPEATS));
    }
}

/// Eight views at the resolution that gives the paper's 1.75 million candidates (found by the first
/// round, which is not counted).
static stp_result measure(stp_scene* scene, const bench_options* options, json_t* results)
{
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    stp_capture_textures* textures = NULL;
    stp_result result = stp_scene_flatten(scene, scene->root, SIZE_MAX, &parts, &part_count);
    result = result == STP_OK ? stp_capture_textures_create(scene, false, &textures) : result;
    stp_capture_desc desc = {.no_fill = true,
                             .textures = textures,
                             .wanted_candidates = options->quick ? 200000 : 1750000};
    lap warm, rounds[REPEATS];
    result = result == STP_OK ? run_round(scene, parts, part_count, &desc, &warm) : result;
    for (int i = 0; i < REPEATS && result == STP_OK; ++i) {
        desc.resolution = warm.resolution;
        result = run_round(scene, parts, part_count, &desc, &rounds[i]);
    }
    if (result == STP_OK) {
        report(rounds, stp_context_thread_count(scene->context), results);
    }
    stp_capture_textures_destroy(textures);
    stp_free(scene->context, parts);
    return result;
}

static int run_capture(const bench_options* options, json_t* results)
{
    static const uint32_t threads[] = {1, 0}; // 0: all
    for (size_t t = 0; t < 2; ++t) {
        stp_context* context = tool_context_create(threads[t], 0, "none");
        if (context == NULL) {
            return 1;
        }
        stp_scene* scene = measured_model_load(context, options, "capture");
        stp_result result = scene != NULL ? measure(scene, options, results) : STP_ERROR_FORMAT;
        if (scene != NULL) {
            stp_scene_destroy(scene);
            if (result != STP_OK) {
                tool_error("bench capture: %s", stp_result_string(result));
            }
        }
        stp_context_destroy(context);
        if (result != STP_OK) {
            return 1;
        }
    }
    return 0;
}

const benchmark benchmark_capture = {
    .name = "capture",
    .summary = "captured triangles per second, and candidates made from them (Brandt, Table 2)",
    .run = run_capture,
};
