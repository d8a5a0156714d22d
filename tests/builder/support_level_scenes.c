// SPDX-License-Identifier: MIT
#include "support_level_scenes.h"

#include "lod/support_level_shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static stp_result generate(stp_scene* scene, const char* name, void* user)
{
    const level_build* build = user;
    (void)name;
    return build->make(scene) ? STP_OK : STP_ERROR_OUT_OF_MEMORY;
}

stp_result level_build_to(stp_context* context, const level_build* build, const char* path,
                          stp_build_report* report)
{
    level_build copy = *build;
    const char* inputs[] = {"scene:levels"};
    const stp_build_desc desc = {.inputs = inputs,
                                 .input_count = 1,
                                 .output = path,
                                 .partition = {.leaf_triangles = build->leaf_triangles},
                                 .blue = {.capture = {.wanted_candidates = 20000}},
                                 .threshold = build->no_splats ? UINT64_C(1) << 40 : 0,
                                 .no_levels = build->no_levels,
                                 .coarse = build->coarse,
                                 .fresh = build->fresh,
                                 .generate = generate,
                                 .generate_user = &copy};
    return stp_build(context, &desc, report);
}

stp_store* level_build_open(stp_context* context, const level_build* build)
{
    char folder[64] = "stp_levels_XXXXXX", path[96];
    if (mkdtemp(folder) == NULL) {
        return NULL;
    }
    snprintf(path, sizeof(path), "%s/a.stip", folder);
    stp_store* store = NULL;
    stp_result result = level_build_to(context, build, path, NULL);
    result = result == STP_OK ? stp_store_open(context, path, &store) : result;
    unlink(path); // an open store keeps its bytes
    rmdir(folder);
    return result == STP_OK ? store : NULL;
}

bool level_scene_torus(stp_scene* scene)
{
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    return level_add(scene, level_torus(scene->context, 125, 80, 1.0, 0.4), red,
                     stp_affine_identity()) != STP_NONE;
}

bool level_scene_open_ball(stp_scene* scene)
{
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    uint32_t blue = level_add_material(scene, 0.1f, 0.2f, 0.9f);
    return level_add(scene, level_ball(scene->context, 80, 40, 8, 1.0), red,
                     stp_affine_identity()) != STP_NONE &&
           level_add(scene, level_torus(scene->context, 80, 40, 0.5, 0.2), blue,
                     stp_affine_identity()) != STP_NONE;
}

bool level_scene_two_tori(stp_scene* scene)
{
    stp_affine aside = {{{1, 0, 0, 3}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f);
    return level_scene_torus(scene) &&
           level_add(scene, level_torus(scene->context, 80, 60, 1.0, 0.3), red, aside) != STP_NONE;
}

bool level_scene_add_textured_sheet(stp_scene* scene, uint32_t cells, uint32_t material)
{
    uint32_t side = cells + 1;
    stp_mesh mesh = {
        .vertex_count = side * side, .triangle_count = 2 * cells * cells, .material = material};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 3 * (size_t)mesh.vertex_count);
    mesh.texcoords[0] = STP_NEW_ARRAY(scene->context, float, 2 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * (size_t)mesh.triangle_count);
    if (mesh.positions == NULL || mesh.texcoords[0] == NULL || mesh.indices == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
        float u = (float)(i % side) / (float)cells, v = (float)(i / side) / (float)cells;
        const float at[3] = {2.0f * u - 1.0f, 1.0f - 2.0f * v, 0.0f};
        memcpy(mesh.positions + 3 * (size_t)i, at, sizeof(at));
        mesh.texcoords[0][2 * (size_t)i] = u;
        mesh.texcoords[0][2 * (size_t)i + 1] = v;
    }
    for (uint32_t i = 0; i < cells * cells; ++i) {
        uint32_t a = i / cells * side + i % cells, c = a + side;
        const uint32_t corners[6] = {a, c, c + 1, a, c + 1, a + 1};
        memcpy(mesh.indices + 6 * (size_t)i, corners, sizeof(corners));
    }
    const stp_object sheet = {
        .name = "sheet", .parent = STP_NONE, .transform = stp_affine_identity()};
    uint32_t index = 0;
    return stp_scene_add_mesh(scene, &mesh, &index) == STP_OK &&
           stp_scene_add_object(scene, &sheet, NULL) == STP_OK &&
           stp_scene_add_part(scene, (stp_part){STP_PART_MESH, index}) == STP_OK;
}

bool level_scene_sheet(stp_scene* scene)
{
    uint32_t gray = level_add_material(scene, 0.5f, 0.5f, 0.5f);
    return level_add(scene, level_sheet(scene->context, 100, 1.0, 0.02), gray,
                     stp_affine_identity()) != STP_NONE;
}

bool level_scene_add_copies(stp_scene* scene)
{
    bool good = true;
    for (uint32_t i = 0; i < 24 && good; ++i) {
        const stp_object object = {
            .parent = STP_NONE,
            .transform = {{{1, 0, 0, 3.0 * (i % 5)}, {0, 1, 0, 0}, {0, 0, 1, 3.0 * (i / 5)}}}};
        good = stp_scene_add_object(scene, &object, NULL) == STP_OK &&
               stp_scene_add_use(scene, i % 3 == 0 ? 1 : 0) == STP_OK;
    }
    return good;
}

bool level_scene_copies(stp_scene* scene)
{
    uint32_t red = level_add_material(scene, 0.8f, 0.1f, 0.1f), torus[2];
    stp_mesh meshes[2] = {level_torus(scene->context, 60, 40, 1.0, 0.4),
                          level_torus(scene->context, 40, 30, 1.0, 0.3)};
    bool good = red != STP_NONE;
    for (int i = 0; i < 2; ++i) {
        const stp_object prototype = {
            .parent = STP_NONE, .transform = stp_affine_identity(), .flags = STP_OBJECT_PROTOTYPE};
        meshes[i].material = red;
        good = good && stp_scene_add_mesh(scene, &meshes[i], &torus[i]) == STP_OK &&
               stp_scene_add_object(scene, &prototype, NULL) == STP_OK &&
               stp_scene_add_part(scene, (stp_part){STP_PART_MESH, torus[i]}) == STP_OK;
    }
    return good && level_scene_add_copies(scene);
}
