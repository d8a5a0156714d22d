// SPDX-License-Identifier: MIT
#include "lab/scenes/mesh_builder.h"

#include <assert.h>

enum { BATCH = 64 }; // meshes made at a time, before they are added in order

typedef struct batch {
    stp_context* context;
    const mesh_recipe* recipes;
    mesh_builder builders[BATCH];
} batch;

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    batch* b = user;
    for (size_t i = begin; i < end; ++i) {
        mesh_builder_init(&b->builders[i], b->context);
        b->recipes[i].make(&b->builders[i], b->recipes[i].parameters);
    }
}

// The scene takes ownership of the arrays.
static stp_result add_mesh(stp_scene* scene, const mesh_recipe* recipe, mesh_builder* builder,
                           uint32_t* index)
{
    stp_mesh mesh = {
        .name = recipe->name,
        .vertex_count = (uint32_t)builder->vertex_count,
        .triangle_count = (uint32_t)(builder->index_count / 3),
        .positions = builder->positions,
        .normals = builder->normals,
        .colors = builder->colors,
        .indices = builder->indices,
        .material = recipe->material,
    };
    builder->positions = builder->normals = NULL;
    builder->colors = NULL;
    builder->indices = NULL;
    return stp_scene_add_mesh(scene, &mesh, index);
}

size_t count_triangles(mesh_maker make, const void* parameters)
{
    mesh_builder builder;
    mesh_builder_init(&builder, NULL);
    builder.counting = true;
    make(&builder, parameters);
    return builder.index_count / 3;
}

stp_result make_meshes(stp_scene* scene, const mesh_recipe* recipes, size_t count,
                       uint32_t* first_mesh)
{
    *first_mesh = (uint32_t)scene->mesh_count;
    stp_result result = STP_OK;
    batch* b = STP_NEW_ARRAY(scene->context, batch, 1);
    if (b == NULL) {
        return stp_fail_memory(scene->context);
    }
    b->context = scene->context;
    for (size_t first = 0; result == STP_OK && first < count; first += BATCH) {
        size_t size = count - first < BATCH ? count - first : BATCH;
        b->recipes = recipes + first;
        stp_parallel_for(scene->context, size, 1, make_some, b);
        for (size_t i = 0; i < size; ++i) {
            if (result == STP_OK) {
                result = b->builders[i].failed
                             ? stp_fail_memory(scene->context)
                             : add_mesh(scene, &b->recipes[i], &b->builders[i], NULL);
            }
            mesh_builder_destroy(&b->builders[i]);
        }
        if (result == STP_OK) {
            result =
                stp_progress(scene->context, "generate", (double)(first + size) / (double)count);
        }
    }
    assert(result != STP_OK || scene->mesh_count == *first_mesh + count);
    stp_free(scene->context, b);
    return result;
}
