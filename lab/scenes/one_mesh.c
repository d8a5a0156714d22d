// SPDX-License-Identifier: MIT
//
// One mesh with any number of triangles: the faces of a cube as grids, inflated to a rock.
#include "lab/scenes/compose.h"
#include "lab/scenes/noise.h"

#define TRIANGLES 1e6 // at scale 1

typedef struct rock {
    uint32_t cells; ///< along an edge of the cube
    uint64_t seed;
    float* positions;
    uint32_t* indices;
} rock;

static size_t side_vertices(const rock* r)
{
    return (size_t)(r->cells + 1) * (r->cells + 1);
}

// Points on the common edge of two faces are identical: both compute them from the same point of
// the cube.
static stp_vec3d rock_point(const rock* r, uint32_t face, uint32_t column, uint32_t row)
{
    double u = 2.0 * (double)column / (double)r->cells - 1.0;
    double v = 2.0 * (double)row / (double)r->cells - 1.0;
    double w = face < 3 ? 1.0 : -1.0;
    v = face < 3 ? v : -v;
    double axes[3];
    axes[face % 3] = w;
    axes[(face + 1) % 3] = u;
    axes[(face + 2) % 3] = v;
    stp_vec3d p = stp_normalized((stp_vec3d){axes[0], axes[1], axes[2]});
    double height = 1.0 + 0.5 * noise3_octaves(r->seed, 2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 7);
    return stp_scaled(p, height);
}

// Rows of all six faces.
static void make_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const rock* r = user;
    uint32_t width = r->cells + 1;
    for (size_t at = begin; at < end; ++at) {
        uint32_t face = (uint32_t)(at / width), row = (uint32_t)(at % width);
        size_t first = face * side_vertices(r) + (size_t)row * width;
        for (uint32_t column = 0; column < width; ++column) {
            stp_vec3 p = stp_to_float(rock_point(r, face, column, row));
            float* out = r->positions + 3 * (first + column);
            out[0] = p.x;
            out[1] = p.y;
            out[2] = p.z;
        }
        uint32_t* index = r->indices + 6 * ((size_t)face * r->cells + row) * r->cells;
        for (uint32_t column = 0; row < r->cells && column < r->cells; ++column, index += 6) {
            uint32_t a = (uint32_t)(first + column), b = a + 1, c = a + width, d = c + 1;
            uint32_t corners[6] = {a, b, d, a, d, c};
            for (int i = 0; i < 6; ++i) {
                index[i] = corners[i];
            }
        }
    }
}

stp_result scene_make_one_mesh(stp_scene* scene, const scene_options* options)
{
    rock r = {.cells = (uint32_t)sqrt(TRIANGLES * options->scale / 12.0), .seed = options->seed};
    r.cells = r.cells < 1 ? 1 : r.cells;
    uint32_t material, index;
    stp_mesh mesh = {.name = "rock",
                     .vertex_count = (uint32_t)(6 * side_vertices(&r)),
                     .triangle_count = 12 * r.cells * r.cells};
    stp_result result = add_plain_material(scene, "stone", 0xa89888, 0.9, &material);
    r.positions = STP_NEW_ARRAY(scene->context, float, 3 * (size_t)mesh.vertex_count);
    r.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * (size_t)mesh.triangle_count);
    if (result != STP_OK || r.positions == NULL || r.indices == NULL) {
        stp_free(scene->context, r.positions);
        stp_free(scene->context, r.indices);
        return result == STP_OK ? stp_fail_memory(scene->context) : result;
    }
    stp_parallel_for(scene->context, 6 * (size_t)(r.cells + 1), 8, make_rows, &r);
    mesh.positions = r.positions;
    mesh.indices = r.indices;
    mesh.material = material;
    stp_affine still = stp_affine_identity();
    result = stp_scene_add_mesh(scene, &mesh, &index);
    result = result == STP_OK ? add_mesh_object(scene, "rock", STP_NONE, &still, index) : result;
    result = result != STP_OK
                 ? result
                 : add_view(scene, "front", (stp_vec3d){0, 0, 4}, (stp_vec3d){0, 0, 0}, 40.0);
    return result == STP_OK ? add_view(scene, "near", (stp_vec3d){0.9, 0.7, 1.6},
                                       (stp_vec3d){0.3, 0.2, 0.8}, 50.0)
                            : result;
}
