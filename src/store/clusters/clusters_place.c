// SPDX-License-Identifier: MIT
// Rounds vertices to the mesh's grid.
#include "store/clusters/clusters_encode.h"

#include <assert.h>

typedef float lanes_float __attribute__((vector_size(16)));
typedef int32_t lanes_int __attribute__((vector_size(16)));

int32_t stp_clusters_round(double value)
{
    double limit = (double)CLUSTERS_NUMBER_LIMIT;
    value = value > limit ? limit : value < -limit ? -limit : value;
    int32_t whole = (int32_t)value;
    double rest = value - whole; // exact
    return whole + (rest >= 0.5) - (rest < -0.5);
}

/// stp_clusters_round of three floats times a power of two, in single precision. Product, integer part
/// and fraction are exact, except for values that round to 0.
static void round_place(lanes_float position, float scale, uint32_t normal, cluster_place* place)
{
    const lanes_float half = {0.5f, 0.5f, 0.5f, 0.5f};
    lanes_float value = position * scale;
    lanes_int whole = __builtin_convertvector(value, lanes_int);
    lanes_float rest = value - __builtin_convertvector(whole, lanes_float);
    whole += (rest < -half) - (rest >= half); // true is -1
    whole[3] = (int32_t)normal;
    memcpy(place, &whole, sizeof(*place));
}

static uint32_t read_normal(const stp_store_mesh* mesh, size_t vertex)
{
    const int16_t* normals = mesh->normals;
    return normals != NULL ? clusters_join_normal(normals[2 * vertex], normals[2 * vertex + 1]) : 0;
}

void stp_clusters_place_vertices(const stp_store_mesh* mesh, double inverse_step,
                                 cluster_place* places)
{
    assert(inverse_step > 0.0 && inverse_step < HUGE_VAL);
    const bool narrow = inverse_step < 0x1p-126 || inverse_step > 0x1p127; // no normal float
    const float scale = narrow ? 0.0f : (float)inverse_step;
    const size_t count = mesh->vertex_count;
    for (size_t v = 0; v < count; ++v) {
        const float* p = mesh->positions + 3 * v;
        uint32_t normal = read_normal(mesh, v);
        if (narrow) {
            for (size_t k = 0; k < 3; ++k) {
                places[v].at[k] = stp_clusters_round((double)p[k] * inverse_step);
            }
            places[v].normal = normal;
            continue;
        }
        lanes_float position = {0};
        memcpy(&position, p, v + 1 < count ? sizeof(position) : 3 * sizeof(float));
        position[3] = 0.0f; // belongs to the next vertex
        round_place(position, scale, normal, &places[v]);
    }
}
