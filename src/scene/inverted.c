// SPDX-License-Identifier: MIT
#include "base/core/context.h"
#include "base/math/closed_surface.h"
#include "scene/finish_steps.h"

#include <assert.h>

/// Whether a mesh is a closed surface whose fronts face inwards.
static bool faces_inwards(const stp_mesh* mesh)
{
    stp_closed_surface surface = {0};
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i += 3) {
        const float* corners[3];
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = mesh->positions + 3 * (size_t)mesh->indices[i + k];
        }
        stp_closed_surface_add(&surface,
                               (const float* const[3]){corners[0], corners[1], corners[2]});
    }
    return stp_closed_surface_side(&surface) < 0;
}

typedef struct inverted_search {
    const stp_scene* scene;
    bool* inverted; ///< of each mesh
} inverted_search;

static void look_at_meshes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const inverted_search* s = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_mesh* mesh = &s->scene->meshes[i];
        s->inverted[i] = s->scene->materials[mesh->material].front_only && faces_inwards(mesh);
    }
}

stp_result stp_scene_find_inverted(stp_scene* scene)
{
    bool any = false;
    for (size_t i = 0; i < scene->material_count; ++i) {
        scene->materials[i].inverted = 0;
        any = any || scene->materials[i].front_only;
    }
    if (!any) {
        return STP_OK;
    }
    inverted_search s = {scene, STP_NEW_ZEROED(scene->context, bool, scene->mesh_count + 1)};
    if (s.inverted == NULL) {
        return stp_fail_memory(scene->context);
    }
    stp_parallel_for(scene->context, scene->mesh_count, 4, look_at_meshes, &s);
    uint32_t count = 0, first = 0;
    for (uint32_t i = 0; i < scene->mesh_count; ++i) {
        if (s.inverted[i]) {
            assert(scene->meshes[i].material < scene->material_count);
            scene->materials[scene->meshes[i].material].inverted += 1;
            first = count++ == 0 ? i : first;
        }
    }
    if (count > 0) {
        const char* name = scene->meshes[first].name;
        stp_warn(scene->context,
                 "closed meshes of single-sided materials face inwards, and only their inside is "
                 "drawn: %u, the first is mesh %u (%s)",
                 count, first, name != NULL ? name : "no name");
    }
    stp_free(scene->context, s.inverted);
    return STP_OK;
}
