// SPDX-License-Identifier: MIT
// Benchmark of encoding triangles as clusters and decoding them, on one thread: speed, and bytes
// per triangle.
#include "base/core/clock.h"
#include "builder/meshes.h"
#include "import/reading/import.h"
#include "lab/bench/bench.h"
#include "lab/scenes/scenes.h"
#include "lab/scenes/solids.h"
#include "program/options/program.h"

#include <string.h>

enum { REPEATS = 5 };

typedef struct coding {
    uint64_t triangles, bytes, clusters;
    double encode_ms, decode_ms;
} coding;

/// The data of a mesh that drawing needs: positions and indices of each cluster.
static float decode_mesh(const stp_coded_mesh* coded)
{
    static float positions[3 * STP_CLUSTER_VERTICES];
    static uint32_t indices[3 * STP_CLUSTER_TRIANGLES];
    stp_clusters clusters;
    float sum = 0.0f;
    if (stp_clusters_open(coded->bytes, coded->size, &clusters) != NULL) {
        return sum;
    }
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        stp_cluster cluster;
        stp_clusters_get(&clusters, i, &cluster);
        stp_cluster_positions(&clusters, &cluster, positions);
        stp_cluster_indices(&cluster, 0, indices);
        sum += positions[3 * indices[0]];
    }
    return sum;
}

static stp_result code_mesh(stp_context* context, const stp_scene* scene, const stp_mesh* mesh,
                            coding* out)
{
    static volatile float sink;
    stp_coded_mesh coded;
    double encode[REPEATS], decode[REPEATS];
    uint32_t texcoords = stp_material_texcoords(&scene->materials[mesh->material]);
    for (int repeat = 0; repeat < REPEATS; ++repeat) {
        double start = stp_clock_ms();
        stp_result result = stp_code_mesh(context, mesh, texcoords, &coded);
        if (result != STP_OK) {
            return result;
        }
        encode[repeat] = stp_clock_ms() - start;
        start = stp_clock_ms();
        sink = sink + decode_mesh(&coded);
        decode[repeat] = stp_clock_ms() - start;
        if (repeat == 0) {
            out->triangles += coded.triangle_count;
            out->clusters += coded.cluster_count;
            out->bytes += coded.size;
        }
        stp_coded_mesh_destroy(context, &coded);
    }
    out->encode_ms += bench_median(encode, REPEATS);
    out->decode_ms += bench_median(decode, REPEATS);
    return STP_OK;
}

/// Rows of boxes and lathed parts with hard edges, as written by CAD programs.
static stp_result add_parts(stp_scene* scene, uint32_t count)
{
    static const lathe_ring profile[] = {{0.0, 0.0},  {0.4, 0.0}, {0.4, 0.6}, {0.25, 0.7},
                                         {0.25, 1.4}, {0.2, 1.5}, {0.0, 1.5}};
    mesh_builder builder;
    mesh_builder_init(&builder, scene->context);
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 corner = point3(i % 64 * 1.25, 0.0, i / 64 * 1.25);
        solid_box(&builder, corner, stp_add(corner, point3(0.9, 0.2, 0.9)));
        builder.place.m[0][3] = (double)corner.x + 0.45;
        builder.place.m[1][3] = 0.2;
        builder.place.m[2][3] = (double)corner.z + 0.45;
        solid_lathe(&builder, profile, 7, 48);
        builder.place.m[0][3] = builder.place.m[1][3] = builder.place.m[2][3] = 0.0;
    }
    if (builder.failed) {
        mesh_builder_destroy(&builder);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    stp_mesh mesh = {.vertex_count = (uint32_t)builder.vertex_count,
                     .triangle_count = (uint32_t)(builder.index_count / 3),
                     .positions = builder.positions,
                     .normals = builder.normals,
                     .indices = builder.indices};
    return stp_scene_add_mesh(scene, &mesh, NULL);
}

/// A copy of the scene's first mesh without normals, whose triangles share no vertices.
static stp_result add_soup(stp_scene* scene)
{
    const stp_mesh* from = &scene->meshes[0];
    size_t corners = 3 * (size_t)from->triangle_count;
    stp_mesh mesh = {.vertex_count = (uint32_t)corners, .triangle_count = from->triangle_count};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 3 * corners);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, corners);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < corners; ++i) {
        memcpy(mesh.positions + 3 * i, from->positions + 3 * (size_t)from->indices[i],
               3 * sizeof(float));
        mesh.indices[i] = (uint32_t)i;
    }
    return stp_scene_add_mesh(scene, &mesh, NULL);
}

static stp_result report(stp_scene* scene, size_t first, size_t end, const char* name,
                         json_t* results)
{
    coding sum = {0};
    for (size_t i = first; i < end; ++i) {
        stp_result result = code_mesh(scene->context, scene, &scene->meshes[i], &sum);
        if (result != STP_OK) {
            return result;
        }
    }
    bench_entry entry = bench_result(results, "clusters");
    double count = (double)sum.triangles;
    bench_set_text(entry.params, "mesh", name);
    bench_set_count(entry.params, "triangles", sum.triangles);
    bench_set_number(entry.figures, "encoded_per_second", count / sum.encode_ms * 1000.0);
    bench_set_number(entry.figures, "decoded_per_second", count / sum.decode_ms * 1000.0);
    bench_set_number(entry.figures, "bytes_per_triangle", (double)sum.bytes / count);
    bench_set_number(entry.figures, "triangles_per_cluster", count / (double)sum.clusters);
    return STP_OK;
}

static stp_result measure_own(stp_scene* scene, bool quick, json_t* results)
{
    stp_result result =
        scene_make_input(scene, quick ? "scene:one-mesh,scale=0.1" : "scene:one-mesh", NULL);
    result = result == STP_OK ? report(scene, 0, 1, "smooth", results) : result;
    result = result == STP_OK ? add_soup(scene) : result;
    result = result == STP_OK ? report(scene, 1, 2, "soup", results) : result;
    result = result != STP_OK ? result : add_parts(scene, quick ? 200 : 2000);
    return result == STP_OK ? report(scene, 2, 3, "hard edges", results) : result;
}

static int run_clusters(const bench_options* options, json_t* results)
{
    stp_context* context = tool_context_create(1, 0, "none");
    stp_scene* scene = NULL;
    if (context == NULL) {
        return 1;
    }
    stp_result result = stp_scene_create(context, &scene);
    if (result == STP_OK && options->model != NULL) {
        result = program_is_scene(options->model)
                     ? scene_make_input(scene, options->model, NULL)
                     : stp_import_file(scene, options->model, &(stp_import_desc){0});
        result = result == STP_OK ? report(scene, 0, scene->mesh_count, options->model, results)
                                  : result;
    } else if (result == STP_OK) {
        result = measure_own(scene, options->quick, results);
    }
    stp_scene_destroy(scene);
    stp_context_destroy(context);
    return result == STP_OK ? 0 : 1;
}

const benchmark benchmark_clusters = {
    .name = "clusters",
    .summary = "speed of encoding and decoding clusters of triangles, and their size",
    .run = run_clusters,
};
