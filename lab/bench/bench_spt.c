// SPDX-License-Identifier: MIT
// Sequential Point Trees (Dachsbacher et al. 2003): number of points per view by distance and kind
// of error, the share of processed points that each test rejects (the paper: 10 to 40 %), the time
// to select points by recursive traversal and by sequence, and the build time of both.
#include "base/core/clock.h"
#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "lab/bench/bench.h"
#include "lab/bench/memory_speed.h"
#include "lab/spt/spt_drawing.h"
#include "lod/blue/blue.h"
#include "lod/samples.h"
#include "lod/set_columns.h"
#include "lod/spt/sequence.h"
#include "lod/spt/spt_set.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum {
    POINTS = 200000,
    QUICK_POINTS = 5000,
    DIRECTIONS = 26,
    QUICK_DIRECTIONS = 6,
    DISTANCES = 7,
};

#define PIXEL_ANGLE                                                                                \
    (2.0 * 0.57735026918962576 / 1080.0) // a pixel's height at distance 1: 1080 in 60 degrees
#define MAX_ALLOWED (8.0 * PIXEL_ANGLE)  // sequences are made for up to eight pixels

static const double distances[DISTANCES] = {0.75, 1.5, 3, 6, 12, 24, 48}; // in sizes of the model

typedef struct spt_bench {
    stp_context* context;
    stp_method_samples samples;
    stp_splats surfels; ///< the set that the samples are taken from
    stp_point_tree by_error, by_diameter;
    stp_point_sequence sequence;
    stp_vec3d center;
    double size;
    uint32_t* nodes; ///< room for all
    spt_model model;
    // one of the two, by backend; the other is NULL
    spt_drawing* drawing;
    spt_gl_drawing* gl_drawing;
} spt_bench;

/// Figures of the views from one distance, summed over directions.
typedef struct spt_row {
    uint64_t unified, split, qsplat; ///< points that the traversal selects
    /// Points of the sequence: in the prefix, before its left bound, selected
    uint64_t looked_at, coarse, selected;
    double traverse_ms, sequence_ms;
    spt_times times; ///< drawing times and counts
} spt_row;

/// The first surfels of the exact order, which are spread evenly.
static stp_result make_points(spt_bench* b, const stp_scene* scene, const bench_options* options)
{
    uint8_t* shadings = STP_NEW_ZEROED(b->context, uint8_t, scene->material_count + 1);
    stp_blue_desc desc = {.splat_count = options->count > 0 ? options->count
                                         : options->quick   ? QUICK_POINTS
                                                            : POINTS};
    stp_result result = shadings == NULL
                            ? stp_fail_memory(b->context)
                            : stp_blue_make(scene, scene->root, shadings, &desc, &b->surfels, NULL);
    if (result == STP_OK) {
        const stp_boxd* box = &scene->nodes[scene->root].bounds;
        stp_vec3d size = stp_subd(box->max, box->min);
        b->center = stp_scaled(stp_addd(box->min, box->max), 0.5);
        b->size = sqrt(size.x * size.x + size.y * size.y + size.z * size.z);
        result = b->surfels.count > 0
                     ? stp_method_samples_take(b->context, &b->surfels, NULL, &b->samples)
                     : STP_OK;
    }
    stp_free(b->context, shadings);
    return result;
}

static void report_build(const spt_bench* b, double tree_ms, double sequence_ms, double set_ms,
                         json_t* results)
{
    double points = (double)b->samples.points.count;
    bench_entry e = bench_result(results, "spt build");
    bench_set_count(e.params, "threads", stp_context_thread_count(b->context));
    bench_set_count(e.figures, "points", b->samples.points.count);
    bench_set_count(e.figures, "nodes", b->by_error.count);
    bench_set_number(e.figures, "tree_ms", tree_ms);
    bench_set_number(e.figures, "sequence_ms", sequence_ms);
    bench_set_number(e.figures, "points_per_second", 1e3 * points / (tree_ms + sequence_ms));
    bench_set_number(e.figures, "set_ms", set_ms); // the two, and the splats made of them
    bench_set_number(e.figures, "set_points_per_second", 1e3 * points / set_ms);
}

static stp_result measure_set(const spt_bench* b, const stp_tree_desc* desc, double* ms)
{
    stp_splats set;
    double start = stp_clock_ms();
    stp_result result = stp_spt_make(b->context, &b->surfels, &(stp_spt_desc){.tree = *desc}, &set);
    *ms = stp_clock_ms() - start;
    stp_splats_destroy(b->context, &set);
    return result;
}

static stp_result make_trees(spt_bench* b, json_t* results)
{
    const stp_tree_desc by_error = {STP_TREE_GEOMETRIC, 255},
                        by_diameter = {STP_TREE_DIAMETER, 255};
    double start = stp_clock_ms(), set_ms = 0.0;
    stp_result result =
        stp_point_tree_make(b->context, &b->samples.points, &by_error, &b->by_error);
    double tree_ms = stp_clock_ms() - start;
    start = stp_clock_ms();
    if (result == STP_OK) {
        result =
            stp_point_sequence_make(b->context, &b->by_error, MAX_ALLOWED, false, &b->sequence);
    }
    double sequence_ms = stp_clock_ms() - start;
    result = result == STP_OK ? measure_set(b, &by_error, &set_ms) : result;
    if (result == STP_OK) {
        result = stp_point_tree_make(b->context, &b->samples.points, &by_diameter, &b->by_diameter);
    }
    if (result != STP_OK) {
        return result;
    }
    report_build(b, tree_ms, sequence_ms, set_ms, results);
    b->nodes = STP_NEW_ARRAY(b->context, uint32_t, (size_t)b->by_error.count + 1);
    return b->nodes != NULL ? STP_OK : stp_fail_memory(b->context);
}

/// Spread over the sphere along a spiral.
static stp_vec3d direction_of(uint32_t i, uint32_t count)
{
    double y = 1.0 - 2.0 * ((double)i + 0.5) / (double)count,
           around = 2.399963229728653 * (double)i;
    double across = sqrt(1.0 - y * y);
    return (stp_vec3d){across * cos(around), y, across * sin(around)};
}

static stp_result draw_view(spt_bench* b, const stp_tree_view* from, spt_times* times)
{
    spt_view view;
    if (!spt_model_make_view(&b->model, from, b->center, &view)) {
        return STP_OK;
    }
    if (b->gl_drawing != NULL) {
        return spt_gl_drawing_measure(b->gl_drawing, b->nodes, &view, times);
    }
    spt_drawing_measure(b->drawing, b->nodes, &view, times);
    return STP_OK;
}

/// Selects the points of a view by each traversal and by the sequence, and draws it. The prefix is
/// chosen for the distances of the bounding sphere.
static stp_result add_view(spt_bench* b, stp_vec3d eye, double distance, spt_row* row)
{
    stp_tree_view view = {.eye = eye, .allowed = PIXEL_ANGLE};
    double start = stp_clock_ms();
    row->unified += stp_point_tree_traverse(&b->by_error, &view, b->nodes);
    row->traverse_ms += stp_clock_ms() - start;
    start = stp_clock_ms();
    stp_sequence_range range = stp_point_sequence_range(
        &b->sequence, view.allowed, fmax(distance - 0.5 * b->size, 0.0), distance + 0.5 * b->size);
    assert(range.begin <= range.end && "the left bound lies in the prefix");
    row->selected += stp_point_sequence_select(&b->sequence, &view,
                                               (stp_sequence_range){0, range.end}, b->nodes);
    row->sequence_ms += stp_clock_ms() - start;
    row->looked_at += range.end;
    row->coarse += range.begin;
    row->qsplat += stp_point_tree_traverse(&b->by_diameter, &view, b->nodes);
    stp_result result = draw_view(b, &view, &row->times);
    view.split = true;
    row->split += stp_point_tree_traverse(&b->by_error, &view, b->nodes);
    return result;
}

static void write_times(json_t* figures, const spt_times* t, double each, bool uses_gl)
{
    bench_set_number(figures, "drawn_by_traversal", (double)t->traversal_splats * each);
    bench_set_number(figures, "traversal_draw_ms", t->traversal_ms * each);
    bench_set_number(figures, "traversal_gather_ms", t->gather_ms * each);
    bench_set_number(figures, "drawn_by_sequence", (double)t->sequence_splats * each);
    bench_set_number(figures, "sequence_draw_ms", t->sequence_ms * each);
    bench_set_number(figures, "sequence_test_ms", t->test_ms * each);
    bench_set_number(figures, "drawn_by_groups", (double)t->group_splats * each);
    bench_set_number(figures, "groups_draw_ms", t->group_ms * each);
    bench_set_number(figures, "groups_test_ms", t->group_test_ms * each);
    bench_set_number(figures, "traversal_pixels", (double)t->traversal_pixels * each);
    bench_set_number(figures, "sequence_pixels", (double)t->sequence_pixels * each);
    bench_set_number(figures, "groups_pixels", (double)t->group_pixels * each);
    if (!uses_gl) {
        bench_set_number(figures, "examined_by_directed", (double)t->directed_examined * each);
        bench_set_number(figures, "drawn_by_directed", (double)t->directed_splats * each);
        bench_set_number(figures, "directed_draw_ms", t->directed_ms * each);
        bench_set_number(figures, "directed_test_ms", t->directed_test_ms * each);
        bench_set_number(figures, "directed_pixels", (double)t->directed_pixels * each);
    } else {
        bench_set_number(figures, "submitted_by_sequence", (double)t->sequence_submitted * each);
        bench_set_number(figures, "submitted_by_groups", (double)t->group_submitted * each);
        bench_set_number(figures, "sequence_commands", (double)t->sequence_commands * each);
        bench_set_number(figures, "groups_commands", (double)t->group_commands * each);
    }
}

static stp_result measure_distance(spt_bench* b, double sizes, uint32_t directions, json_t* results)
{
    spt_row row = {0};
    double distance = sizes * b->size;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < directions && result == STP_OK; ++i) {
        stp_vec3d eye = stp_addd(b->center, stp_scaled(direction_of(i, directions), distance));
        result = add_view(b, eye, distance, &row);
    }
    bench_entry e = bench_result(results, "spt distance");
    bench_set_number(e.params, "sizes_away", sizes);
    bench_set_count(e.figures, "unified", row.unified / directions);
    bench_set_count(e.figures, "split", row.split / directions);
    bench_set_count(e.figures, "qsplat", row.qsplat / directions);
    bench_set_count(e.figures, "looked_at", row.looked_at / directions);
    bench_set_count(e.figures, "selected", row.selected / directions);
    bench_set_number(
        e.figures, "rejected_percent",
        row.looked_at > 0 ? 100.0 * (1.0 - (double)row.selected / (double)row.looked_at) : 0.0);
    bench_set_number(e.figures, "left_bound_percent",
                     row.looked_at > 0 ? 100.0 * (double)row.coarse / (double)row.looked_at : 0.0);
    bench_set_number(e.figures, "traverse_ms", row.traverse_ms / (double)directions);
    bench_set_number(e.figures, "sequence_ms", row.sequence_ms / (double)directions);
    write_times(e.figures, &row.times, 1.0 / (double)directions, b->gl_drawing != NULL);
    return result;
}

static stp_result make_drawing(spt_bench* b, bool uses_gl, json_t* results)
{
    stp_result result = spt_model_create(b->context, &b->by_error, &b->surfels, &b->model);
    if (result != STP_OK || !uses_gl) {
        return result == STP_OK ? spt_drawing_create(&b->model, &b->drawing) : result;
    }
    result = spt_gl_drawing_create(&b->model, &b->gl_drawing);
    if (result == STP_OK) {
        bench_entry e = bench_result(results, "spt device");
        bench_set_text(e.params, "backend", "gl");
        bench_set_text(e.params, "device", spt_gl_drawing_device(b->gl_drawing));
    }
    return result;
}

static int run_spt(const bench_options* options, json_t* results)
{
    spt_bench b = {.context = tool_context_create(options->threads, 0, "none")};
    if (b.context == NULL) {
        return 1;
    }
    stp_scene* scene = measured_model_load(b.context, options, "spt");
    stp_result result = scene != NULL ? make_points(&b, scene, options) : STP_ERROR_FORMAT;
    if (scene != NULL) {
        stp_scene_destroy(scene);
    }
    bool any = result == STP_OK && b.samples.points.count > 0;
    result = any ? make_trees(&b, results) : result;
    if (any && result == STP_OK) {
        result = make_drawing(&b, options->uses_gl, results);
    }
    for (int i = 0; i < DISTANCES && any && result == STP_OK; ++i) {
        result = measure_distance(&b, distances[i], options->quick ? QUICK_DIRECTIONS : DIRECTIONS,
                                  results);
    }
    spt_drawing_destroy(b.drawing);
    spt_gl_drawing_destroy(b.gl_drawing);
    spt_model_destroy(&b.model);
    stp_splats_destroy(b.context, &b.surfels);
    stp_free(b.context, b.nodes);
    stp_point_sequence_destroy(b.context, &b.sequence);
    stp_point_tree_destroy(b.context, &b.by_error);
    stp_point_tree_destroy(b.context, &b.by_diameter);
    stp_method_samples_destroy(b.context, &b.samples);
    stp_context_destroy(b.context);
    if (scene != NULL && result == STP_OK && !any) {
        return tool_error("bench spt: no part of the model is visible");
    }
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_spt = {
    .name = "spt",
    .summary = "points that views draw from a point tree and from its sequence (Dachsbacher et "
               "al.)",
    .run = run_spt,
};
