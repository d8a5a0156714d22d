// SPDX-License-Identifier: MIT
// Scenes with nested instances, and the surfels of their nodes, bottom-up.
#pragma once

#include "lod/blue/blue.h"
#include "scene/scene.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef struct hierarchy {
    stp_scene* scene;
    stp_splats* made;        ///< by node
    const stp_splats** sets; ///< by node
    uint8_t* shading_of_material;
    uint32_t shape; ///< the object that leaves use
} hierarchy;

static inline stp_affine scale_and_move(double x, double y, double z, double tx, double ty,
                                        double tz)
{
    return (stp_affine){{{x, 0, 0, tx}, {0, y, 0, ty}, {0, 0, z, tz}}};
}

static inline void hierarchy_destroy(hierarchy* h)
{
    for (size_t i = 0; h->made != NULL && i < h->scene->node_count; ++i) {
        stp_splats_destroy(h->scene->context, &h->made[i]);
    }
    free(h->made);
    free(h->sets);
    free(h->shading_of_material);
    if (h->scene != NULL) {
        stp_scene_destroy(h->scene);
    }
    *h = (hierarchy){0};
}

static inline bool add_grid(stp_scene* scene, uint32_t faces, uint32_t cells, bool round,
                            uint32_t material, uint32_t* index)
{
    uint32_t side = cells + 1, face = side * side;
    stp_mesh mesh = {.vertex_count = faces * face,
                     .triangle_count = 2 * faces * cells * cells,
                     .material = material};
    mesh.positions = STP_NEW_ARRAY(scene->context, float, 3 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(scene->context, uint32_t, 3 * (size_t)mesh.triangle_count);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return false;
    }
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
        float a = (float)(v % face % side) / (float)cells * 2.0f - 1.0f;
        float b = (float)(v % face / side) / (float)cells * 2.0f - 1.0f;
        float s = v / face % 2 == 0 ? 1.0f : -1.0f;
        stp_vec3 p = v / face < 2   ? (stp_vec3){a, b, s}
                     : v / face < 4 ? (stp_vec3){a, s, b}
                                    : (stp_vec3){s, a, b};
        p = round ? stp_normalize(p) : p;
        memcpy(mesh.positions + 3 * (size_t)v, &p, sizeof(p));
    }
    for (uint32_t q = 0; q < faces * cells * cells; ++q) {
        uint32_t in = q % (cells * cells);
        uint32_t i = q / (cells * cells) * face + in / cells * side + in % cells;
        memcpy(mesh.indices + 6 * (size_t)q,
               (uint32_t[6]){i, i + 1, i + side, i + 1, i + side + 1, i + side}, 24);
    }
    return stp_scene_add_mesh(scene, &mesh, index) == STP_OK;
}

/// A scene with one prototype: a unit sphere of 12 cells^2 triangles, or the faces z = 1 and z = -1
/// of a cube.
static inline bool hierarchy_begin(stp_context* context, hierarchy* h, bool sphere, uint32_t cells)
{
    *h = (hierarchy){0};
    uint32_t mesh;
    stp_object object = {
        .parent = STP_NONE, .transform = stp_affine_identity(), .flags = STP_OBJECT_PROTOTYPE};
    return stp_scene_create(context, &h->scene) == STP_OK &&
           add_grid(h->scene, sphere ? 6 : 2, cells, sphere, 0, &mesh) &&
           stp_scene_add_object(h->scene, &object, &h->shape) == STP_OK &&
           stp_scene_add_part(h->scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK;
}

/// Adds an object that shows copies of another one; optionally a prototype.
static inline bool add_copies(hierarchy* h, uint32_t used, const stp_affine* copies, uint32_t count,
                              bool prototype, uint32_t* index)
{
    stp_object object = {.parent = STP_NONE,
                         .transform = stp_affine_identity(),
                         .flags = prototype ? STP_OBJECT_PROTOTYPE : 0};
    bool added = stp_scene_add_object(h->scene, &object, index) == STP_OK;
    for (uint32_t i = 0; added && i < count; ++i) {
        stp_object copy = {.parent = *index, .transform = copies[i]};
        added = stp_scene_add_object(h->scene, &copy, NULL) == STP_OK &&
                stp_scene_add_use(h->scene, used) == STP_OK;
    }
    return added;
}

static inline bool hierarchy_finish(hierarchy* h)
{
    if (stp_scene_finish(h->scene) != STP_OK) {
        return false;
    }
    h->made = calloc(h->scene->node_count, sizeof(*h->made));
    h->sets = calloc(h->scene->node_count, sizeof(*h->sets));
    h->shading_of_material = calloc(h->scene->material_count, 1);
    return h->made != NULL && h->sets != NULL && h->shading_of_material != NULL;
}

/// Surfels of one node, from a capture of about `candidates` candidates.
static inline stp_result hierarchy_make(hierarchy* h, uint32_t node, uint32_t surfels,
                                        uint32_t candidates, stp_blue_report* report)
{
    stp_blue_desc desc = {
        .splat_count = surfels, .capture = {.wanted_candidates = candidates}, .sets = h->sets};
    assert(node < h->scene->node_count && "the scene has the node");
    stp_result result =
        stp_blue_make(h->scene, node, h->shading_of_material, &desc, &h->made[node], report);
    h->sets[node] = &h->made[node];
    return result;
}
