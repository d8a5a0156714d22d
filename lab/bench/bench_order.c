// SPDX-License-Identifier: MIT
//
// Orders 1.75 million candidates of a real model: the exact order with both metrics, the paper's
// two schedules and a random order, interleaved, each choosing 10k, 50k and 100k. It also repeats
// the experiment of Brandt et al. 2019, 3.3: the time of an exact order of 10k when each choice
// scans every candidate.
#include "base/core/clock.h"
#include "capture/capture.h"
#include "lab/bench/bench.h"
#include "lab/measure/distribution.h"
#include "program/files/scene_file.h"

#include <stipple/order.h>

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { REPEATS = 5 };

static const char default_model[] =
    "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb";

// The contestants, and how the figures name them.
enum { EXACT, SIDE, PAPER_FAST, PAPER_TEXT, RANDOM, KINDS };

static const struct {
    const char* name;
    stp_order_kind kind;
    stp_order_metric metric;
} kinds[KINDS] = {
    {"exact", STP_ORDER_EXACT, STP_METRIC_EUCLIDEAN},
    {"side", STP_ORDER_EXACT, STP_METRIC_SIDE},
    {"paper_fast", STP_ORDER_PAPER_FAST, STP_METRIC_EUCLIDEAN},
    {"paper_text", STP_ORDER_PAPER_TEXT, STP_METRIC_EUCLIDEAN},
    {"random", STP_ORDER_RANDOM, STP_METRIC_EUCLIDEAN},
};

typedef struct bench_case {
    stp_context* context;
    const stp_candidates* candidates;
    uint32_t wanted, threads;
    uint32_t* order;
    float* radii;
    float* ordered; // positions
    json_t* results;
} bench_case;

// Captures the model's candidates, fewer for a quick run. @return false with the message printed
static bool capture(stp_context* context, const bench_options* options, stp_candidates* candidates)
{
    const char* path = options->model != NULL ? options->model : default_model;
    stp_scene* scene = NULL;
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    stp_result result = tool_import_scene(context, path, &scene);
    if (result == STP_OK && scene->root == STP_NONE) {
        result = STP_ERROR_FORMAT;
    }
    result = result == STP_OK ? stp_scene_flatten(scene, scene->root, SIZE_MAX, &parts, &part_count)
                              : result;
    if (result == STP_OK) {
        stp_capture_desc desc = {.no_fill = true,
                                 .wanted_candidates = options->quick ? 200000 : 1750000};
        result = stp_capture_parts(scene, parts, part_count, &desc, candidates);
    }
    stp_free(context, parts);
    stp_scene_destroy(scene);
    if (result != STP_OK) {
        tool_error("bench order: %s: %s", path, stp_result_string(result));
    }
    return result == STP_OK;
}

// Orders once. @return milliseconds; negative on failure
static double time_order(const bench_case* c, int kind, uint32_t wanted, float* radii,
                         float* final_radius, uint64_t* lookups)
{
    stp_order_desc desc = {.kind = kinds[kind].kind,
                           .metric = kinds[kind].metric,
                           .seed = 1,
                           .thread_count = c->threads};
    stp_order_report report = {0};
    uint32_t ordered;
    double start = stp_clock_ms();
    stp_result result = stp_order_points(c->context, &desc, c->candidates->positions,
                                         c->candidates->normals, c->candidates->count, wanted,
                                         c->order, radii, &ordered, final_radius, &report);
    *lookups = report.distance_count;
    return result == STP_OK ? stp_clock_ms() - start : -1.0;
}

// Quality of the prefix: its largest distance to a candidate, and its median spacing.
static bool measure_quality(bench_case* c, int kind, json_t* figures, float* coverage)
{
    uint64_t lookups;
    if (time_order(c, kind, c->wanted, c->radii, coverage, &lookups) < 0.0) {
        return false;
    }
    for (uint32_t i = 0; i < c->wanted; ++i) {
        memcpy(c->ordered + 3 * (size_t)i, c->candidates->positions + 3 * (size_t)c->order[i],
               3 * sizeof(float));
    }
    stp_distribution d;
    if (stp_distribution_measure(c->context, c->ordered, c->wanted, c->ordered, c->wanted, NULL,
                                 &d) != STP_OK) {
        return false;
    }
    char key[64];
    snprintf(key, sizeof(key), "%s_coverage_max", kinds[kind].name);
    bench_set_number(figures, key, (double)*coverage);
    snprintf(key, sizeof(key), "%s_spacing_median", kinds[kind].name);
    bench_set_number(figures, key, d.spacing_median);
    return true;
}

#ifndef NDEBUG
static bool radii_never_increase(const float* radii, uint32_t count)
{
    uint32_t i = 1;
    while (i < count && radii[i] <= radii[i - 1]) {
        i += 1;
    }
    return i >= count;
}
#endif

// The shortest exact prefix that covers as well as the full result of the paper's fast schedule.
static uint32_t prefix_as_good(const bench_case* c, float coverage)
{
    assert(radii_never_increase(c->radii, c->wanted) && "an exact order was measured last");
    uint32_t prefix = 1;
    while (prefix < c->wanted && c->radii[prefix] > coverage) {
        prefix += 1;
    }
    return prefix;
}

static bool run_case(bench_case* c)
{
    bench_entry entry = bench_result(c->results, "order");
    bench_set_count(entry.params, "candidates", c->candidates->count);
    bench_set_count(entry.params, "surfels", c->wanted);
    bench_set_count(entry.params, "threads", c->threads);
    bench_set_text(entry.params, "metric", "euclidean");
    float coverage[KINDS];
    for (int k = KINDS - 1; k >= EXACT; --k) { // the exact order last, because its radii are needed
        if (!measure_quality(c, k, entry.figures, &coverage[k])) {
            return false;
        }
    }
    uint32_t as_good = prefix_as_good(c, coverage[PAPER_FAST]);
    double ms[KINDS + 1][REPEATS];
    uint64_t lookups[KINDS + 1] = {0};
    for (int i = 0; i < REPEATS; ++i) {
        for (int k = 0; k <= KINDS; ++k) {
            int kind = k == KINDS ? EXACT : k;
            ms[k][i] =
                time_order(c, kind, k == KINDS ? as_good : c->wanted, NULL, NULL, &lookups[k]);
            if (ms[k][i] < 0.0) {
                return false;
            }
        }
    }
    double median[KINDS + 1];
    for (int k = 0; k <= KINDS; ++k) {
        median[k] = bench_median(ms[k], REPEATS);
    }
    for (int k = 0; k < KINDS; ++k) {
        char key[64];
        snprintf(key, sizeof(key), "%s_ms", kinds[k].name);
        bench_set_number(entry.figures, key, median[k]);
    }
    bench_set_number(entry.figures, "ratio_to_paper_fast", median[EXACT] / median[PAPER_FAST]);
    bench_set_number(entry.figures, "ratio_to_paper_text", median[EXACT] / median[PAPER_TEXT]);
    bench_set_number(entry.figures, "ratio_of_side", median[SIDE] / median[EXACT]);
    bench_set_count(entry.figures, "surfels_covering_as_paper_fast", as_good);
    bench_set_number(entry.figures, "ms_covering_as_paper_fast", median[KINDS]);
    bench_set_number(entry.figures, "ratio_covering_as_paper_fast",
                     median[KINDS] / median[PAPER_FAST]);
    bench_set_number(entry.figures, "paper_fast_lookups_per_second",
                     (double)lookups[PAPER_FAST] / median[PAPER_FAST] * 1000.0);
    bench_set_number(entry.figures, "paper_text_lookups_per_second",
                     (double)lookups[PAPER_TEXT] / median[PAPER_TEXT] * 1000.0);
    return true;
}

// Gonzalez' traversal without a search structure, which took the paper 15 s for 10k surfels.
static double time_naive(const stp_candidates* candidates, uint32_t wanted, float* gaps)
{
    double start = stp_clock_ms();
    const float* positions = candidates->positions;
    uint32_t count = candidates->count, chosen = 0;
    for (uint32_t i = 0; i < count; ++i) {
        gaps[i] = INFINITY;
    }
    for (uint32_t k = 0; k < wanted; ++k) {
        const float* q = positions + 3 * (size_t)chosen;
        float largest = -1.0f, x = q[0], y = q[1], z = q[2];
        for (uint32_t i = 0; i < count; ++i) {
            const float* p = positions + 3 * (size_t)i;
            float dx = p[0] - x, dy = p[1] - y, dz = p[2] - z;
            float squared = (dx * dx + dy * dy) + dz * dz;
            gaps[i] = squared < gaps[i] ? squared : gaps[i];
            if (gaps[i] > largest) {
                largest = gaps[i];
                chosen = i;
            }
        }
    }
    return stp_clock_ms() - start;
}

// Brandt et al., 3.3: 15 s for the exact order of 10k points against 180 ms for the heuristic.
static bool run_naive(bench_case* c)
{
    float* gaps = STP_NEW_ARRAY(c->context, float, c->candidates->count);
    if (gaps == NULL) {
        return false;
    }
    double naive = time_naive(c->candidates, c->wanted, gaps);
    stp_free(c->context, gaps);
    double exact[REPEATS], text[REPEATS];
    uint64_t lookups;
    for (int i = 0; i < REPEATS; ++i) {
        exact[i] = time_order(c, EXACT, c->wanted, NULL, NULL, &lookups);
        text[i] = time_order(c, PAPER_TEXT, c->wanted, NULL, NULL, &lookups);
        if (exact[i] < 0.0 || text[i] < 0.0) {
            return false;
        }
    }
    bench_entry entry = bench_result(c->results, "order-naive");
    bench_set_count(entry.params, "candidates", c->candidates->count);
    bench_set_count(entry.params, "surfels", c->wanted);
    bench_set_count(entry.params, "threads", c->threads);
    double exact_ms = bench_median(exact, REPEATS);
    bench_set_number(entry.figures, "naive_ms", naive);
    bench_set_number(entry.figures, "exact_ms", exact_ms);
    bench_set_number(entry.figures, "paper_text_ms", bench_median(text, REPEATS));
    bench_set_number(entry.figures, "speedup_over_naive", naive / exact_ms);
    return true;
}

static bool run_cases(bench_case* c, bool quick)
{
    static const struct {
        uint32_t wanted, threads;
    } cases[] = {{10000, 1}, {50000, 1}, {100000, 1}, {100000, 2}};
    uint32_t divisor = quick ? 10 : 1;
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        c->wanted = cases[i].wanted / divisor;
        c->threads = cases[i].threads;
        if (c->wanted > c->candidates->count || !run_case(c)) {
            return false;
        }
    }
    c->wanted = 10000 / divisor;
    c->threads = 1;
    return run_naive(c);
}

static int run_order(const bench_options* options, json_t* results)
{
    stp_context* context = tool_context_create(2, 0, "none");
    stp_candidates candidates;
    if (context == NULL) {
        return 1;
    }
    bool good = capture(context, options, &candidates);
    if (good) {
        enum { MOST = 100000 };
        bench_case c = {.context = context, .candidates = &candidates, .results = results};
        c.order = STP_NEW_ARRAY(context, uint32_t, MOST);
        c.radii = STP_NEW_ARRAY(context, float, MOST);
        c.ordered = STP_NEW_ARRAY(context, float, 3 * MOST);
        good = c.order != NULL && c.radii != NULL && c.ordered != NULL &&
               run_cases(&c, options->quick);
        stp_free(context, c.order);
        stp_free(context, c.radii);
        stp_free(context, c.ordered);
        stp_candidates_destroy(context, &candidates);
        if (!good) {
            tool_error("bench order: out of memory, or fewer candidates than surfels");
        }
    }
    stp_context_destroy(context);
    return good ? 0 : 1;
}

const benchmark benchmark_order = {
    .name = "order",
    .summary =
        "exact orders and the paper's schedules, on captured candidates (Brandt, 3.2 and 3.3)",
    .run = run_order,
};
