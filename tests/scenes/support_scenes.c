// SPDX-License-Identifier: MIT
#include "support_scenes.h"

#include <string.h>

scene_sums sum_scene(const stp_scene* scene)
{
    scene_sums sums = {0};
    bool* used = calloc(scene->mesh_count + 1, sizeof(*used));
    for (size_t i = 0; used != NULL && i < scene->node_part_count; ++i) {
        uint32_t mesh = scene->node_parts[i].index;
        sums.unique_objects += used[mesh] ? 0 : 1;
        sums.unique_triangles += used[mesh] ? 0 : scene->meshes[mesh].triangle_count;
        used[mesh] = true;
    }
    free(used);
    uint64_t* placed = calloc(scene->node_count + 1, sizeof(*placed));
    for (size_t i = 0; placed != NULL && i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        placed[i] = node->part_count;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            placed[i] += placed[scene->edges[node->first_edge + k].node];
        }
    }
    if (placed != NULL && scene->root != STP_NONE) {
        sums.objects = placed[scene->root];
        sums.triangles = scene->nodes[scene->root].triangle_count;
    }
    free(placed);
    return sums;
}

stp_scene* make_scene(stp_context* context, const char* name, double scale, uint64_t seed)
{
    stp_scene* scene = NULL;
    scene_options options = {.scale = scale, .seed = seed};
    if (stp_scene_create(context, &scene) == STP_OK &&
        scene_make(scene, name, &options) == STP_OK && stp_scene_finish(scene) == STP_OK) {
        return scene;
    }
    stp_scene_destroy(scene);
    return NULL;
}

static stp_hash hash_text(stp_hash hash, const char* text)
{
    return text != NULL ? stp_hash_bytes(hash, text, strlen(text) + 1) : hash;
}

stp_hash hash_scene(const stp_scene* scene)
{
    stp_hash hash = {0};
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const stp_mesh* m = &scene->meshes[i];
        hash = stp_hash_bytes(hash, m->positions, 12 * (size_t)m->vertex_count);
        hash = stp_hash_bytes(hash, m->indices, 12 * (size_t)m->triangle_count);
        if (m->normals != NULL) {
            hash = stp_hash_bytes(hash, m->normals, 12 * (size_t)m->vertex_count);
        }
        if (m->colors != NULL) {
            hash = stp_hash_bytes(hash, m->colors, 8 * (size_t)m->vertex_count);
        }
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        const stp_object* o = &scene->objects[i];
        hash = hash_text(hash, o->name);
        hash = stp_hash_bytes(hash, o->transform.m, sizeof(o->transform.m));
        uint32_t words[4] = {o->parent, o->part_count, o->instance_count, o->use};
        hash = stp_hash_bytes(hash, words, sizeof(words));
    }
    for (size_t i = 0; i < scene->material_count; ++i) {
        hash = stp_hash_bytes(hash, scene->materials[i].base_color, 4 * sizeof(float));
    }
    return stp_hash_bytes(hash, scene->instances, scene->instance_count * sizeof(stp_affine));
}
