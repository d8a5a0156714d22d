// SPDX-License-Identifier: MIT
// Capture, and with it Table 2 of Brandt et al. 2019: rendering a model from eight sides, making candidates of
// what is seen, and ordering 10k, 50k and 100k of them.
#include "bench.h"

#include "base/rng.h"
#include "capture/capture.h"
#include "import/import.h"

#include <stipple/order.h>

#include <stdio.h>
#include <string.h>

enum { REPEATS = 5, COUNTS = 3 };

static const uint32_t counts[COUNTS] = {10000, 50000, 100000};

/// Smooth noise in -1..1 on the integer lattice.
static float noise(float x, float y, float z)
{
    float at[3] = {x + 64.0f, y + 64.0f, z + 64.0f}, f[3];
    uint64_t cell[3];
    for (int k = 0; k < 3; ++k) {
        cell[k] = (uint64_t)at[k];
        float t = at[k] - (float)cell[k];
        f[k] = t * t * (3.0f - 2.0f * t);
    }
    float sum = 0.0f;
    for (uint64_t corner = 0; corner < 8; ++corner) {
        uint64_t a = corner & 1, b = corner >> 1 & 1, c = corner >> 2;
        uint64_t bits = stp_rng_hash(11, ((cell[2] + c) * 256 + cell[1] + b) * 256 + cell[0] + a);
        float weight = (a != 0 ? f[0] : 1.0f - f[0]) * (b != 0 ? f[1] : 1.0f - f[1]) *
                       (c != 0 ? f[2] : 1.0f - f[2]);
        sum += weight * ((float)(bits >> 40) / 8388608.0f - 1.0f);
    }
    return sum;
}

/// A point of a cube's face, blown up to a ball with hills.
static stp_vec3 hilly_ball(uint32_t face, float a, float b)
{
    float s = face % 2 == 0 ? 1.0f : -1.0f;
    stp_vec3 p = face < 2   ? (stp_vec3){s, a, b}
                 : face < 4 ? (stp_vec3){a, s, b}
                            : (stp_vec3){a, b, s};
    p = stp_normalize(p);
    float height = 1.0f;
    float scale = 3.0f, size = 0.12f;
    for (int octave = 0; octave < 4; ++octave) {
        height += size * noise(p.x * scale, p.y * scale, p.z * scale);
        scale *= 2.0f;
        size *= 0.5f;
    }
    return stp_scale(p, height);
}

/// A ball with hills of 12 cells^2 triangles, as one mesh.
static stp_result generate(stp_scene* scene, uint32_t cells)
{
    uint32_t side = cells + 1, face_vertices = side * side;
    stp_mesh mesh = {.vertex_count = 6 * face_vertices, .triangle_count = 12 * cells * cells};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 3 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * (size_t)mesh.triangle_count);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    uint32_t* index = mesh.indices;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
        uint32_t in_face = v % face_vertices;
        uint32_t column = in_face % side, row = in_face / side;
        float a = (float)column / (float)cells * 2.0f - 1.0f;
        float b = (float)row / (float)cells * 2.0f - 1.0f;
        stp_vec3 p = hilly_ball(v / face_vertices, a, b);
        memcpy(mesh.positions + 3 * (size_t)v, &p, sizeof(p));
    }
    for (uint32_t q = 0; q < 6 * cells * cells; ++q) {
        uint32_t in_face = q % (cells * cells);
        uint32_t i = q / (cells * cells) * face_vertices + in_face / cells * side + in_face % cells;
        memcpy(index, (uint32_t[6]){i, i + 1, i + side, i + 1, i + side + 1, i + side}, 24);
        index += 6;
    }
    uint32_t mesh_index;
    stp_object object = {.name = "ball", .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_mesh(scene, &mesh, &mesh_index);
    result = result == STP_OK ? stp_scene_add_object(scene, &object, NULL) : result;
    return result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh_index})
                            : result;
}

/// The model, or the generated mesh; NULL where it fails (message printed).
static stp_scene* load(stp_context* context, const bench_options* options)
{
    stp_scene* scene = NULL;
    stp_result result = stp_scene_create(context, &scene);
    if (result == STP_OK && options->model != NULL) {
        result = stp_import_file(scene, options->model, &(stp_import_desc){0});
    } else if (result == STP_OK) {
        result = generate(scene, options->quick ? 130 : 660);
    }
    result = result == STP_OK ? stp_scene_finish(scene) : result;
    if (result == STP_OK && scene->root != STP_NONE) {
        return scene;
    }
    tool_error("bench capture: %s",
               result == STP_OK ? "nothing to see" : stp_result_string(result));
    stp_scene_destroy(scene);
    return NULL;
}

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

/// Eight views at the resolution at which the paper's 1.75 million candidates come out (found by the first round,
/// which is not counted).
static stp_result measure(stp_scene* scene, const bench_options* options, json_t* results)
{
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    stp_capture_textures* textures = NULL;
    stp_result result = stp_scene_flatten(scene, scene->root, SIZE_MAX, &parts, &part_count);
    result = result == STP_OK ? stp_capture_textures_create(scene, &textures) : result;
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
        stp_scene* scene = load(context, options);
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
    .summary = "triangles seen a second from all sides; candidates made of them (Brandt, Table 2)",
    .run = run_capture,
};
