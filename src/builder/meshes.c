// SPDX-License-Identifier: MIT
#include "builder/meshes.h"

#include "base/math/position_grid.h"
#include "base/splats/octahedral.h"
#include "builder/stored_results.h"

#include <assert.h>
#include <pthread.h>
#include <string.h>

// Part of every key: increase when the same mesh gives other bytes.
static const char* const code_version = "stipple-clusters-4";

typedef struct run {
    const stp_scene* scene;
    stp_work* work;
    stp_previous_output* previous;
    stp_build_draft* draft;
    stp_build_meshes* meshes;
    stp_build_result* origins;      ///< one per mesh
    pthread_mutex_t mutex;          ///< guards the result
    pthread_mutex_t previous_mutex; ///< a store allows one thread at a time
    stp_result result;              ///< the first failure
} run;

uint32_t stp_material_texcoords(const stp_material* material)
{
    const stp_texture_use* uses[] = {&material->base_color_texture,
                                     &material->metallic_roughness_texture,
                                     &material->emissive_texture, &material->normal_texture};
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
    assert(texcoords <= 3 && "a mesh has two sets of texture coordinates");
    stp_store_mesh source = {
        .name = mesh->name,
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count,
        .positions = mesh->positions,
        .texcoords = {(texcoords & 1) != 0 ? mesh->texcoords[0] : NULL,
                      (texcoords & 2) != 0 ? mesh->texcoords[1] : NULL},
        .colors = mesh->colors,
        .indices = mesh->indices,
        .is_piece = mesh->is_piece,
    };
    int16_t* normals = NULL;
    if (mesh->normals != NULL) {
        normals = stp_alloc_array(context, mesh->vertex_count, 2 * sizeof(*normals));
        if (normals == NULL) {
            *coded = (stp_coded_mesh){0};
            return stp_fail_memory(context);
        }
        stp_octahedral_encode16_many(mesh->normals, mesh->vertex_count, normals);
        source.normals = normals;
    }
    double step = mesh->grid_step > 0.0
                      ? mesh->grid_step
                      : stp_choose_grid_step(mesh->positions, mesh->indices, mesh->triangle_count);
    stp_result result = stp_clusters_encode(context, &source, step, coded);
    stp_free(context, normals);
    return result;
}

static stp_hash make_key(const stp_mesh* mesh, uint32_t texcoords)
{
    stp_hash key = stp_hash_bytes((stp_hash){0}, code_version, strlen(code_version));
    key = stp_hash_bytes(key, &mesh->content, sizeof(mesh->content));
    key = stp_hash_bytes(key, &mesh->grid_step, sizeof(mesh->grid_step));
    return stp_hash_bytes(key, &texcoords, sizeof(texcoords));
}

static bool find_mesh(run* r, stp_hash key, stp_coded_mesh* coded)
{
    if (stp_work_find_mesh(r->work, key, coded)) {
        return true;
    }
    pthread_mutex_lock(&r->previous_mutex);
    bool found =
        r->previous != NULL && stp_previous_output_take_mesh(r->previous, key, r->work, coded);
    pthread_mutex_unlock(&r->previous_mutex);
    return found;
}

static stp_result make_mesh(run* r, const stp_mesh* mesh, uint32_t texcoords, stp_hash key,
                            stp_coded_mesh* coded)
{
    stp_coded_mesh made;
    stp_result result = stp_code_mesh(r->scene->context, mesh, texcoords, &made);
    if (result == STP_OK) {
        result = stp_work_store_mesh(r->work, key, &made, coded);
        stp_coded_mesh_destroy(r->scene->context, &made);
    }
    return result;
}

static void code_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    run* r = user;
    stp_build_meshes* meshes = r->meshes;
    for (size_t i = begin; i < end; ++i) {
        const stp_mesh* mesh = &r->scene->meshes[i];
        assert(mesh->material < r->scene->material_count);
        uint32_t texcoords = stp_material_texcoords(&r->scene->materials[mesh->material]);
        stp_hash key = make_key(mesh, texcoords);
        meshes->keys[i] = key;
        bool found = find_mesh(r, key, &meshes->coded[i]);
        stp_result result = found ? STP_OK : make_mesh(r, mesh, texcoords, key, &meshes->coded[i]);
        r->origins[i] = (stp_build_result){key, !found};
        pthread_mutex_lock(&r->mutex);
        r->result = r->result == STP_OK ? result : r->result;
        pthread_mutex_unlock(&r->mutex);
        stp_progress_add(r->scene->context, mesh->triangle_count);
        if (result != STP_OK) {
            stp_parallel_stop(r->scene->context);
        } else {
            stp_build_draft_add_mesh(r->draft, i, &meshes->coded[i]);
        }
    }
}

stp_result stp_build_meshes_make(const stp_scene* scene, stp_work* work,
                                 stp_previous_output* previous, stp_build_draft* draft,
                                 stp_build_meshes* meshes)
{
    stp_context* context = scene->context;
    *meshes = (stp_build_meshes){0};
    meshes->coded = STP_NEW_ZEROED(context, stp_coded_mesh, scene->mesh_count);
    meshes->keys = STP_NEW_ZEROED(context, stp_hash, scene->mesh_count);
    run r = {.scene = scene, .work = work, .previous = previous, .draft = draft, .meshes = meshes};
    r.origins = STP_NEW_ZEROED(context, stp_build_result, scene->mesh_count);
    if (meshes->coded == NULL || meshes->keys == NULL || r.origins == NULL) {
        stp_free(context, r.origins);
        stp_build_meshes_destroy(context, meshes);
        return stp_fail_memory(context);
    }
    stp_loop_report report = {.stage = "clusters", .unit = "triangles"};
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        report.total += scene->meshes[i].triangle_count;
    }
    pthread_mutex_init(&r.mutex, NULL);
    pthread_mutex_init(&r.previous_mutex, NULL);
    stp_result result =
        stp_parallel_for_reported(context, scene->mesh_count, 1, code_some, &r, &report);
    pthread_mutex_destroy(&r.previous_mutex);
    pthread_mutex_destroy(&r.mutex);
    result = r.result == STP_OK ? result : r.result;
    if (result == STP_OK) {
        meshes->found = (uint32_t)stp_build_count_found(r.origins, scene->mesh_count);
        assert(meshes->found <= scene->mesh_count);
        meshes->made = (uint32_t)scene->mesh_count - meshes->found;
    } else {
        stp_build_meshes_destroy(context, meshes);
    }
    stp_free(context, r.origins);
    return result;
}

void stp_build_meshes_destroy(stp_context* context, stp_build_meshes* meshes)
{
    stp_free(context, meshes->coded);
    stp_free(context, meshes->keys);
    meshes->coded = NULL;
    meshes->keys = NULL;
}
