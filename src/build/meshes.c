// SPDX-License-Identifier: MIT
#include "build/meshes.h"

#include "base/octahedral.h"
#include "base/position_grid.h"

uint32_t stp_material_texcoords(const stp_material* material)
{
    const stp_texture_use* uses[] = {&material->base_color_texture,
                                     &material->metallic_roughness_texture,
                                     &material->emissive_texture};
    uint32_t sets = 0;
    for (size_t i = 0; i < sizeof(uses) / sizeof(uses[0]); ++i) {
        if (uses[i]->texture != STP_NONE) {
            sets |= 1u << (uses[i]->texcoord != 0 ? 1 : 0);
        }
    }
    return sets;
}

stp_result stp_code_mesh(stp_context* context, const stp_mesh* mesh, uint32_t texcoords,
                         stp_coded_mesh* coded)
{
    stp_store_mesh source = {
        .name = mesh->name,
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count,
        .positions = mesh->positions,
        .texcoords = {(texcoords & 1) != 0 ? mesh->texcoords[0] : NULL,
                      (texcoords & 2) != 0 ? mesh->texcoords[1] : NULL},
        .colors = mesh->colors,
        .indices = mesh->indices,
    };
    int16_t* normals = NULL;
    if (mesh->normals != NULL) {
        normals = stp_alloc_array(context, mesh->vertex_count, 2 * sizeof(*normals));
        if (normals == NULL) {
            *coded = (stp_coded_mesh){0};
            return stp_fail_memory(context);
        }
        for (size_t i = 0; i < mesh->vertex_count; ++i) {
            const float* n = mesh->normals + 3 * i;
            stp_octahedral_encode16((stp_vec3){n[0], n[1], n[2]}, normals + 2 * i);
        }
        source.normals = normals;
    }
    double step = mesh->grid_step > 0.0
                      ? mesh->grid_step
                      : stp_choose_grid_step(mesh->positions, mesh->indices, mesh->triangle_count);
    stp_result result = stp_clusters_encode(context, &source, step, coded);
    stp_free(context, normals);
    return result;
}

typedef struct code_work {
    const stp_scene* scene;
    stp_build_content* content;
    stp_result* results;
} code_work;

static void code_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const code_work* work = user;
    const stp_scene* scene = work->scene;
    for (size_t i = begin; i < end; ++i) {
        const stp_mesh* mesh = &scene->meshes[i];
        uint32_t texcoords = stp_material_texcoords(&scene->materials[mesh->material]);
        work->results[i] = stp_code_mesh(scene->context, mesh, texcoords, &work->content->coded[i]);
    }
}

stp_result stp_code_meshes(const stp_scene* scene, stp_build_content* content)
{
    stp_context* context = scene->context;
    size_t count = scene->mesh_count;
    content->coded = STP_NEW_ZEROED(context, stp_coded_mesh, count + 1);
    code_work work = {scene, content, STP_NEW_ZEROED(context, stp_result, count + 1)};
    stp_result result = STP_OK;
    if (content->coded == NULL || work.results == NULL) {
        result = stp_fail_memory(context);
    } else {
        stp_parallel_for(context, count, 1, code_some, &work);
        for (size_t i = 0; i < count && result == STP_OK; ++i) {
            result = work.results[i];
        }
        content->content.coded_meshes = content->coded;
    }
    stp_free(context, work.results);
    return result;
}
