// SPDX-License-Identifier: MIT
// Benchmark of levels of triangles: how many are left at an error, and how long all levels take. The
// meshes of a model are joined, as they are placed, and welded by position.
#include "base/core/clock.h"
#include "import/reading/import.h"
#include "lab/bench/bench.h"
#include "lab/decimate/contraction.h"
#include "lab/scenes/scenes.h"
#include "lod/levels/level_graph.h"
#include "program/options/program.h"

#include <string.h>

enum { USES_MAX = 1 << 20, ERRORS = 7 };

/// Errors at which triangles are counted: the diagonal divided by these.
static const double shares[ERRORS] = {3200, 1600, 800, 400, 200, 100, 50};

/// All triangles of a scene, in one space.
typedef struct soup {
    float* positions;
    uint32_t* indices;
    size_t vertex_count, triangle_count;
} soup;

static stp_result join_meshes(const stp_scene* scene, soup* s)
{
    stp_placed_part* parts = NULL;
    size_t count = 0;
    stp_result result = stp_scene_flatten(scene, scene->root, USES_MAX, &parts, &count);
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        if (parts[i].part.kind == STP_PART_MESH) {
            const stp_mesh* mesh = &scene->meshes[parts[i].part.index];
            s->vertex_count += mesh->vertex_count;
            s->triangle_count += mesh->triangle_count;
        }
    }
    if (result == STP_OK && (s->vertex_count > INT32_MAX || s->triangle_count > INT32_MAX / 3)) {
        result = stp_fail(scene->context, STP_ERROR_LIMIT,
                          "bench levels: the model has %zu triangles, expected at most %d",
                          s->triangle_count, INT32_MAX / 3);
    }
    if (result == STP_OK) {
        s->positions = STP_NEW_ARRAY(scene->context, float, 3 * s->vertex_count + 1);
        s->indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * s->triangle_count + 1);
        result =
            s->positions != NULL && s->indices != NULL ? STP_OK : stp_fail_memory(scene->context);
    }
    size_t vertices = 0, corners = 0;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        if (parts[i].part.kind != STP_PART_MESH) {
            continue;
        }
        const stp_mesh* mesh = &scene->meshes[parts[i].part.index];
        for (size_t k = 0; k < 3 * (size_t)mesh->triangle_count; ++k) {
            s->indices[corners++] = (uint32_t)vertices + mesh->indices[k];
        }
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            const float* p = mesh->positions + 3 * v;
            stp_vec3 placed = stp_to_float(stp_affine_point(
                &parts[i].transform, (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]}));
            memcpy(s->positions + 3 * vertices++, &placed, sizeof(placed));
        }
    }
    stp_free(scene->context, parts);
    return result;
}

static void report(const stp_level_graph* g, const char* model, uint32_t originals, double diagonal,
                   double seconds, json_t* results)
{
    bench_entry entry = bench_result(results, "levels");
    bench_set_text(entry.params, "model", model);
    bench_set_count(entry.params, "triangles", originals);
    bench_set_number(entry.figures, "seconds", seconds);
    bench_set_number(entry.figures, "microseconds_per_triangle",
                     1e6 * seconds / (originals > 0 ? originals : 1));
    bench_set_count(entry.figures, "stored_triangles", g->triangle_count);
    bench_set_count(entry.figures, "clusters", g->cluster_count);
    bench_set_count(entry.figures, "groups", g->group_count);
    bench_set_count(entry.figures, "levels",
                    g->group_count > 0 ? g->groups[g->group_count - 1].level : 0);
    for (int e = 0; e < ERRORS; ++e) {
        char key[64];
        uint64_t drawn = 0;
        double allowed = diagonal / shares[e];
        for (uint32_t i = 0; i < g->cluster_count; ++i) {
            drawn += stp_level_is_drawn(g, i, allowed, allowed) ? g->clusters[i].triangle_count : 0;
        }
        snprintf(key, sizeof(key), "triangles_at_diagonal_by_%.0f", shares[e]);
        bench_set_count(entry.figures, key, drawn);
    }
}

static stp_result measure(stp_context* context, const stp_scene* scene, const char* model,
                          json_t* results)
{
    soup s = {0};
    stp_distinct distinct = {0};
    stp_level_graph graph = {0};
    stp_result result = join_meshes(scene, &s);
    stp_decimate_input input = {.count = (uint32_t)s.vertex_count, .positions = s.positions};
    result = result == STP_OK ? stp_distinct_make(context, &input, &distinct) : result;
    if (result == STP_OK) {
        stp_box box = stp_box_empty();
        for (size_t i = 0; i < distinct.count; ++i) {
            const float* p = distinct.positions + 3 * i;
            stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
        }
        double diagonal = (double)stp_length(stp_sub(box.max, box.min));
        stp_level_source mesh = {.vertex_count = distinct.count,
                                 .triangle_count = stp_distinct_weld(
                                     &distinct, s.indices, (uint32_t)s.triangle_count, s.indices),
                                 .positions = distinct.positions,
                                 .indices = s.indices};
        stp_level_desc desc = stp_level_defaults(diagonal);
        double start = stp_clock_ms();
        result = diagonal > 0.0 ? stp_level_graph_make(context, &mesh, &desc, &graph) : STP_OK;
        double seconds = 1e-3 * (stp_clock_ms() - start);
        if (result == STP_OK) {
            report(&graph, model, mesh.triangle_count, diagonal, seconds, results);
        }
    }
    stp_level_graph_destroy(context, &graph);
    stp_distinct_destroy(context, &distinct);
    stp_free(context, s.positions);
    stp_free(context, s.indices);
    return result;
}

static int run_levels(const bench_options* options, json_t* results)
{
    const char* model = options->model != NULL ? options->model
                        : options->quick       ? "scene:one-mesh,scale=0.05"
                                               : "scene:one-mesh";
    stp_context* context = tool_context_create(options->threads, 0, "none");
    stp_scene* scene = NULL;
    if (context == NULL) {
        return 1;
    }
    stp_result result = stp_scene_create(context, &scene);
    if (result == STP_OK) {
        result = program_is_scene(model) ? scene_make_input(scene, model, NULL)
                                         : stp_import_file(scene, model, &(stp_import_desc){0});
    }
    result = result == STP_OK ? stp_scene_finish(scene) : result;
    result = result == STP_OK ? measure(context, scene, model, results) : result;
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_levels = {
    .name = "levels",
    .summary = "levels of triangles: how many are left at an error, and the time to make them",
    .run = run_levels,
};
