// SPDX-License-Identifier: MIT
#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/noise.h"
#include "lab/scenes/scene_random.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/terrain.h"
#include "lab/scenes/trees.h"

#define TREES 1000.0
#define SPACING 9.0 // approximate metres between trees

typedef struct clearing {
    uint64_t seed;
    double half; ///< half of its side, in metres
    int cells;
} clearing;

static double ground_height(uint64_t seed, double x, double z)
{
    return 9.0 * noise2(seed, x / 110.0, z / 110.0) + 1.2 * noise2(seed + 1, x / 17.0, z / 17.0);
}

static void make_ground(mesh_builder* builder, const void* parameters)
{
    const clearing* c = parameters;
    for (int row = 0; row <= c->cells; ++row) {
        for (int column = 0; column <= c->cells; ++column) {
            double x = c->half * (2.0 * column / c->cells - 1.0);
            double z = c->half * (2.0 * row / c->cells - 1.0), y = ground_height(c->seed, x, z);
            double dry = 0.5 + 0.5 * noise2_octaves(c->seed + 3, x / 20.0, z / 20.0, 4);
            mesh_builder_color(builder, 0.06 + 0.10 * dry, 0.10 + 0.05 * dry, 0.03 + 0.03 * dry);
            mesh_builder_vertex(builder, point3(x, y, z),
                                point3(y - ground_height(c->seed, x + 1.0, z), 1.0,
                                       y - ground_height(c->seed, x, z + 1.0)));
        }
    }
    uint32_t width = (uint32_t)c->cells + 1;
    for (uint32_t i = 0; i < width * width; ++i) {
        if (i % width < width - 1 && i / width < width - 1) {
            mesh_builder_triangle(builder, i, i + width, i + width + 1);
            mesh_builder_triangle(builder, i, i + width + 1, i + 1);
        }
    }
}

static stp_result add_trees(stp_scene* scene, const clearing* c, uint32_t side, uint32_t first)
{
    random_stream random = random_begin(c->seed);
    stp_result result = STP_OK;
    for (uint32_t i = 0; result == STP_OK && i < side * side; ++i) {
        double x = SPACING * ((double)(i % side) + random_unit(&random) - 0.5 * side);
        double z = SPACING * ((double)(i / side) + random_unit(&random) - 0.5 * side);
        x += x > -5.0 && x < 5.0 ? (x < 0.0 ? -5.0 : 5.0) : 0.0; // keeps a path free
        double grove = noise2(c->seed + 8, x / 60.0, z / 60.0) + 0.7 * random_unit(&random);
        uint32_t kind = grove < 0.0 ? 2 : grove < 0.25 ? 1 : grove < 0.5 ? 0 : grove < 0.7 ? 5 : 3;
        kind = random_below(&random, 12) == 0 ? 4 : kind;
        double turns = random_unit(&random);
        double size = random_between(&random, 0.7, 1.15);
        stp_affine place = place_turned(x, ground_height(c->seed, x, z) - 0.1, z, turns, size);
        result = add_mesh_object(scene, tree_name(kind), 0, &place, first + kind);
    }
    return result;
}

stp_result scene_make_forest(stp_scene* scene, const scene_options* options)
{
    uint32_t side = (uint32_t)sqrt(TREES * options->scale), material = 0, ground, first;
    side = side < 2 ? 2 : side;
    clearing c = {.seed = options->seed, .half = 0.5 * SPACING * side + 12.0};
    c.cells = (int)c.half;
    stp_affine still = stp_affine_identity();
    stp_result result = add_group(scene, "forest", STP_NONE, &still, NULL);
    result =
        result == STP_OK ? add_plain_material(scene, "ground", 0xffffff, 0.95, &material) : result;
    mesh_recipe recipe = {"ground", make_ground, &c, material};
    result = result == STP_OK ? make_meshes(scene, &recipe, 1, &ground) : result;
    result = result == STP_OK ? add_mesh_object(scene, "ground", 0, &still, ground) : result;
    result = result == STP_OK
                 ? terrain_add_tree_meshes(scene, options->seed, 64.0 * options->scale, &first)
                 : result;
    result = result == STP_OK ? add_trees(scene, &c, side, first) : result;
    double far = c.half;
    result = result == STP_OK ? add_view(scene, "overview", (stp_vec3d){far, 0.8 * far, 1.3 * far},
                                         (stp_vec3d){0, 0, 0}, 50.0)
                              : result;
    return result != STP_OK
               ? result
               : add_view(scene, "walk",
                          (stp_vec3d){0.0, ground_height(c.seed, 0, 0.9 * far) + 1.8, 0.9 * far},
                          (stp_vec3d){0.0, 6.0, 0.0}, 60.0);
}

stp_result scene_make_terrain(stp_scene* scene, const scene_options* options)
{
    stp_affine still = stp_affine_identity();
    stp_result result = scene_add_terrain(scene, STP_NONE, &still, options, NULL);
    result = result == STP_OK ? add_view(scene, "overview", (stp_vec3d){-2800, 500, 2000},
                                         (stp_vec3d){-800, 0, 500}, 60.0)
                              : result;
    result = result == STP_OK ? add_view(scene, "road", (stp_vec3d){-1000, 40, 300},
                                         (stp_vec3d){-600, 0, 40}, 60.0)
                              : result;
    return result;
}
