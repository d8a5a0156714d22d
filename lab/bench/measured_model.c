// SPDX-License-Identifier: MIT
#include "base/math/rng.h"
#include "import/reading/import.h"
#include "lab/bench/memory_speed.h"

#include <assert.h>
#include <string.h>

/// Smooth noise in -1..1 on the integer lattice.
static float noise(float x, float y, float z)
{
    float at[3] = {x + 64.0f, y + 64.0f, z + 64.0f}, f[3];
    uint64_t cell[3];
    for (int k = 0; k < 3; ++k) {
        assert(at[k] >= 0.0f && at[k] < 255.0f && "cells of 256 per axis are hashed");
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
    assert(index == mesh.indices + 3 * (size_t)mesh.triangle_count);
    uint32_t mesh_index;
    stp_object object = {.name = "ball", .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_mesh(scene, &mesh, &mesh_index);
    result = result == STP_OK ? stp_scene_add_object(scene, &object, NULL) : result;
    return result == STP_OK ? stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh_index})
                            : result;
}

stp_scene* measured_model_load(stp_context* context, const bench_options* options,
                               const char* benchmark_name)
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
    tool_error("bench %s: %s", benchmark_name,
               result == STP_OK ? "nothing is visible" : stp_result_string(result));
    stp_scene_destroy(scene);
    return NULL;
}
