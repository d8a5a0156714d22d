// SPDX-License-Identifier: MIT
// Sequential Point Trees (Dachsbacher et al. 2003): how many points a view takes by distance and kind of error, how many of
// those that are looked at the test of each rejects (the paper: 10 to 40 %), and how long the recursive traversal and the
// sequence take to select them.
#include "bench.h"
#include "measured_model.h"
#include "spt_drawing.h"

#include "base/clock.h"
#include "base/octahedral.h"
#include "base/prefix_table.h"
#include "lod/blue/blue.h"
#include "lod/spt/samples.h"
#include "lod/spt/sequence.h"

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
    (2.0 * 0.57735026918962576 / 1080.0) // of 1080 pixels in 60 degrees, at distance 1
#define MOST_ALLOWED (8.0 * PIXEL_ANGLE) // sequences are made for up to eight pixels

static const double distances[DISTANCES] = {0.75, 1.5, 3, 6, 12, 24, 48}; // in sizes of the model

typedef struct spt_bench {
    stp_context* context;
    stp_spt_samples samples;
    stp_surfels surfels; ///< that they are taken from
    stp_point_tree by_error, by_diameter;
    stp_point_sequence sequence;
    stp_vec3d center;
    double size;
    uint32_t* nodes; ///< room for all
    spt_drawing* drawing;
} spt_bench;

/// What views from one distance take, summed over directions.
typedef struct spt_row {
    uint64_t unified, split, qsplat; ///< points that the traversal selects
    uint64_t looked_at, coarse,
        selected; ///< of the sequence: in the prefix, before its left bound, selected
    double traverse_ms, sequence_ms;
    spt_times times; ///< of drawing
} spt_row;

/// The leading surfels of the exact order, which are spread evenly.
static stp_result make_points(spt_bench* b, const stp_scene* scene, const bench_options* options)
{
    uint8_t* shadings = STP_NEW_ZEROED(b->context, uint8_t, scene->material_count + 1);
    stp_blue_desc desc = {.surfel_count = options->count > 0 ? options->count
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
        result = b->surfels.count > 0 ? stp_spt_samples_take(b->context, &b->surfels, &b->samples)
                                      : STP_OK;
    }
    stp_free(b->context, shadings);
    return result;
}

static stp_result make_trees(spt_bench* b, json_t* results)
{
    const stp_tree_desc by_error = {STP_TREE_GEOMETRIC, 255},
                        by_diameter = {STP_TREE_DIAMETER, 255};
    double start = stp_clock_ms();
    stp_result result =
        stp_point_tree_make(b->context, &b->samples.points, &by_error, &b->by_error);
    double tree_ms = stp_clock_ms() - start;
    start = stp_clock_ms();
    if (result == STP_OK) {
        result = stp_point_sequence_make(b->context, &b->by_error, MOST_ALLOWED, &b->sequence);
    }
    double sequence_ms = stp_clock_ms() - start;
    if (result == STP_OK) {
        result = stp_point_tree_make(b->context, &b->samples.points, &by_diameter, &b->by_diameter);
    }
    if (result != STP_OK) {
        return result;
    }
    b->nodes = STP_NEW_ARRAY(b->context, uint32_t, (size_t)b->by_error.count + 1);
    bench_entry e = bench_result(results, "spt build");
    bench_set_count(e.figures, "points", b->samples.points.count);
    bench_set_count(e.figures, "nodes", b->by_error.count);
    bench_set_number(e.figures, "tree_ms", tree_ms);
    bench_set_number(e.figures, "sequence_ms", sequence_ms);
    bench_set_number(e.figures, "points_per_second",
                     1e3 * (double)b->samples.points.count / (tree_ms + sequence_ms));
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

/// A view by all ways. Distances of the prefix are those of the bounding sphere.
static void add_view(spt_bench* b, stp_vec3d eye, double distance, spt_row* row)
{
    stp_tree_view view = {.eye = eye, .allowed = PIXEL_ANGLE};
    double start = stp_clock_ms();
    row->unified += stp_point_tree_traverse(&b->by_error, &view, b->nodes);
    row->traverse_ms += stp_clock_ms() - start;
    start = stp_clock_ms();
    stp_sequence_range range = stp_point_sequence_range(
        &b->sequence, view.allowed, fmax(distance - 0.5 * b->size, 0.0), distance + 0.5 * b->size);
    row->selected += stp_point_sequence_select(&b->sequence, &view,
                                               (stp_sequence_range){0, range.end}, b->nodes);
    row->sequence_ms += stp_clock_ms() - start;
    row->looked_at += range.end;
    row->coarse += range.begin;
    row->qsplat += stp_point_tree_traverse(&b->by_diameter, &view, b->nodes);
    spt_drawing_measure(b->drawing, &b->by_error, b->nodes, &view, b->center, &row->times);
    view.split = true;
    row->split += stp_point_tree_traverse(&b->by_error, &view, b->nodes);
}

static void measure_distance(spt_bench* b, double sizes, uint32_t directions, json_t* results)
{
    spt_row row = {0};
    double distance = sizes * b->size;
    for (uint32_t i = 0; i < directions; ++i) {
        stp_vec3d eye = stp_addd(b->center, stp_scaled(direction_of(i, directions), distance));
        add_view(b, eye, distance, &row);
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
    double each = 1.0 / (double)directions;
    bench_set_number(e.figures, "drawn_by_traversal", (double)row.times.traversal_splats * each);
    bench_set_number(e.figures, "traversal_draw_ms", row.times.traversal_ms * each);
    bench_set_number(e.figures, "drawn_by_sequence", (double)row.times.sequence_splats * each);
    bench_set_number(e.figures, "sequence_draw_ms", row.times.sequence_ms * each);
    bench_set_number(e.figures, "sequence_test_ms", row.times.test_ms * each);
    bench_set_number(e.figures, "drawn_by_groups", (double)row.times.group_splats * each);
    bench_set_number(e.figures, "groups_draw_ms", row.times.group_ms * each);
    bench_set_number(e.figures, "groups_test_ms", row.times.group_test_ms * each);
}

static int run_spt(const bench_options* options, json_t* results)
{
    spt_bench b = {.context = tool_context_create(0, 0, "none")};
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
        result = spt_drawing_create(b.context, &b.by_error, &b.surfels, &b.drawing);
    }
    for (int i = 0; i < DISTANCES && any && result == STP_OK; ++i) {
        measure_distance(&b, distances[i], options->quick ? QUICK_DIRECTIONS : DIRECTIONS, results);
    }
    spt_drawing_destroy(b.drawing);
    stp_surfels_destroy(b.context, &b.surfels);
    stp_free(b.context, b.nodes);
    stp_point_sequence_destroy(b.context, &b.sequence);
    stp_point_tree_destroy(b.context, &b.by_error);
    stp_point_tree_destroy(b.context, &b.by_diameter);
    stp_spt_samples_destroy(b.context, &b.samples);
    stp_context_destroy(b.context);
    if (scene != NULL && result == STP_OK && !any) {
        return tool_error("bench spt: nothing can be seen of the model");
    }
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_spt = {
    .name = "spt",
    .summary = "points that views take of a point tree, and of its sequence (Dachsbacher et al.)",
    .run = run_spt,
};
