// SPDX-License-Identifier: MIT
// Small scenes for tests.
#pragma once

#include "scene/scene.h"

#include <string.h>

/// A mesh of `triangles` triangles in a row along x, starting at `at`. Different arguments give
/// different content.
static inline stp_mesh make_strip_mesh(stp_context* context, uint32_t triangles, float at)
{
    stp_mesh mesh = {.vertex_count = triangles + 2, .triangle_count = triangles};
    mesh.positions = STP_NEW_ARRAY(context, float, 3 * (size_t)mesh.vertex_count);
    mesh.indices = STP_NEW_ARRAY(context, uint32_t, 3 * (size_t)triangles);
    for (uint32_t i = 0; mesh.positions != NULL && i < mesh.vertex_count; ++i) {
        float* p = mesh.positions + 3 * (size_t)i;
        p[0] = at + (float)i * 0.5f;
        p[1] = (float)(i % 2);
        p[2] = 0.0f;
    }
    for (uint32_t i = 0; mesh.indices != NULL && i < 3 * triangles; ++i) {
        mesh.indices[i] = i / 3 + i % 3;
    }
    return mesh;
}

/// Adds such a mesh; false if out of memory.
static inline bool add_strip(stp_scene* scene, uint32_t triangles, float at, uint32_t* index)
{
    stp_mesh mesh = make_strip_mesh(scene->context, triangles, at);
    if (mesh.positions == NULL || mesh.indices == NULL) {
        stp_free(scene->context, mesh.positions);
        stp_free(scene->context, mesh.indices);
        return false;
    }
    return stp_scene_add_mesh(scene, &mesh, index) == STP_OK;
}

static inline stp_affine make_translation(double x, double y, double z)
{
    return (stp_affine){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
}

/// Adds an object without parts.
static inline bool add_object(stp_scene* scene, uint32_t parent, stp_affine transform,
                              uint32_t flags, uint32_t* index)
{
    return stp_scene_add_object(
               scene, &(stp_object){.parent = parent, .transform = transform, .flags = flags},
               index) == STP_OK;
}

/// Adds an object that shows one mesh.
static inline bool add_mesh_object(stp_scene* scene, uint32_t parent, stp_affine transform,
                                   uint32_t mesh, uint32_t* index)
{
    return add_object(scene, parent, transform, 0, index) &&
           stp_scene_add_part(scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK;
}
