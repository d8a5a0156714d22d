// SPDX-License-Identifier: MIT
#include "lab/scenes/compose.h"
#include "lab/scenes/mesh_builder.h"
#include "lab/scenes/scene_random.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/trigonometry.h"

#include <stdio.h>

// The largest integer whose `power`-th power is at most x (but at least 1).
static uint32_t whole_root(double x, int power)
{
    uint32_t root = 1;
    for (;; ++root) {
        double value = 1.0;
        for (int i = 0; i < power; ++i) {
            value *= (double)(root + 1);
        }
        if (value > x * (1.0 + 1e-12)) {
            return root;
        }
    }
}

static void make_unit_box(mesh_builder* builder, const void* parameters)
{
    (void)parameters;
    solid_box(builder, point3(-0.5, -0.5, -0.5), point3(0.5, 0.5, 0.5));
}

stp_result scene_make_boxes(stp_scene* scene, const scene_options* options)
{
    uint32_t side = whole_root(27.0 * options->scale, 3), group, number = 0;
    double middle = 0.75 * (double)(side - 1), far = 1.5 * (double)side;
    random_stream random = random_begin(options->seed);
    stp_affine still = stp_affine_identity();
    stp_result result = add_group(scene, "boxes", STP_NONE, &still, &group);
    for (; result == STP_OK && number < side * side * side; ++number) {
        char name[32];
        uint32_t material, mesh;
        double x = 1.5 * (double)(number % side), y = 1.5 * (double)(number / side % side),
               z = 1.5 * (double)(number / side / side);
        snprintf(name, sizeof(name), "box %u", number + 1);
        result = add_plain_material(scene, name, 0x404040 | (uint32_t)random_bits(&random), 0.6,
                                    &material);
        mesh_recipe recipe = {.name = name, .make = make_unit_box, .material = material};
        stp_affine place = place_at(x - middle, y - middle, z - middle);
        result = result == STP_OK ? make_meshes(scene, &recipe, 1, &mesh) : result;
        result = result == STP_OK ? add_mesh_object(scene, name, group, &place, mesh) : result;
    }
    result = result == STP_OK ? add_view(scene, "front", (stp_vec3d){0, 0, 1.6 * far},
                                         (stp_vec3d){0, 0, 0}, 45.0)
                              : result;
    return result == STP_OK ? add_view(scene, "corner", (stp_vec3d){far, 0.8 * far, far},
                                       (stp_vec3d){0, 0, 0}, 45.0)
                            : result;
}

// Evenly spread points on the unit sphere, a golden angle apart.
static stp_vec3d sphere_point(uint32_t i, uint32_t count)
{
    double y = 1.0 - (2.0 * (double)i + 1.0) / (double)count, r = sqrt(1.0 - y * y);
    double turns = (double)i * 0.38196601125010515180;
    return (stp_vec3d){r * turn_cosine(turns), y, r * turn_sine(turns)};
}

static stp_affine sphere_place(uint32_t i, uint32_t count)
{
    stp_vec3d p = sphere_point(i, count);
    double scale = 1.6 / sqrt((double)count);
    return place_turned(p.x, p.y, p.z, (double)i / (double)count, scale);
}

static void make_unit_sphere(mesh_builder* builder, const void* parameters)
{
    solid_sphere(builder, (stp_vec3){0}, 1.0, *(const int*)parameters);
}

// Three levels: every object of the second is written separately, and found equal by its content.
stp_result scene_make_spheres(stp_scene* scene, const scene_options* options)
{
    uint32_t count = whole_root(262144.0 * options->scale, 3), material, mesh, top;
    count = count < 4 ? 4 : count;
    int levels = 4;
    stp_affine still = stp_affine_identity();
    stp_result result = add_plain_material(scene, "enamel", 0xd0a040, 0.4, &material);
    mesh_recipe recipe = {"sphere", make_unit_sphere, &levels, material};
    result = result == STP_OK ? make_meshes(scene, &recipe, 1, &mesh) : result;
    result = result == STP_OK ? add_group(scene, "spheres", STP_NONE, &still, &top) : result;
    for (uint32_t i = 0; result == STP_OK && i < count; ++i) {
        uint32_t middle;
        stp_affine place = sphere_place(i, count);
        result = add_group(scene, "sphere of spheres", top, &place, &middle);
        for (uint32_t k = 0; result == STP_OK && k < count; ++k) {
            place = sphere_place(k, count);
            result = add_mesh_object(scene, "spheres on a sphere", middle, &place, mesh);
            for (uint32_t n = 0; result == STP_OK && n < count; ++n) {
                place = sphere_place(n, count);
                result = stp_scene_add_instance(scene, &place);
            }
        }
    }
    result = result != STP_OK
                 ? result
                 : add_view(scene, "front", (stp_vec3d){0, 0, 3.6}, (stp_vec3d){0, 0, 0}, 45.0);
    return result != STP_OK
               ? result
               : add_view(scene, "near", (stp_vec3d){0.4, 0.35, 1.6}, (stp_vec3d){0, 0, 0.9}, 50.0);
}
