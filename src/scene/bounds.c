// SPDX-License-Identifier: MIT
//
// The tight box of the whole scene. A node's own bounds contain the transformed boxes of its
// children, so every rotation on the way up enlarges them. The root's bounds frame views and scale
// distances, so they are computed from the vertices if that takes reasonable time.
#include "scene/finish_steps.h"

#include <assert.h>

#define MAX_ELEMENTS ((uint64_t)1 << 26) // triangles and points: about a second of one thread

typedef struct bounds_work {
    const stp_scene* scene;
    const stp_placed_part* parts;
    stp_boxd* boxes; ///< tight box of each part
} bounds_work;

static stp_boxd measure_part(const stp_scene* scene, const stp_placed_part* placed)
{
    stp_boxd box = stp_boxd_empty();
    bool is_mesh = placed->part.kind == STP_PART_MESH;
    const stp_mesh* mesh = is_mesh ? &scene->meshes[placed->part.index] : NULL;
    const stp_point_set* set = is_mesh ? NULL : &scene->point_sets[placed->part.index];
    const float* positions = is_mesh ? mesh->positions : set->positions;
    size_t count = is_mesh ? 3 * (size_t)mesh->triangle_count : set->point_count;
    for (size_t i = 0; i < count; ++i) { // unused vertices do not count
        const float* p = positions + 3 * (is_mesh ? (size_t)mesh->indices[i] : i);
        stp_vec3d point = {(double)p[0], (double)p[1], (double)p[2]};
        stp_boxd_add(&box, stp_affine_point(&placed->transform, point));
    }
    return box;
}

static void measure_parts(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    bounds_work* work = user;
    for (size_t i = begin; i < end; ++i) {
        work->boxes[i] = measure_part(work->scene, &work->parts[i]);
    }
}

stp_result stp_scene_tighten_root(stp_scene* scene)
{
    assert(scene->root < scene->node_count);
    const stp_node* root = &scene->nodes[scene->root];
    if (root->triangle_count > MAX_ELEMENTS ||
        root->point_count > MAX_ELEMENTS - root->triangle_count) {
        return STP_OK; // each part has at least one element, so this limits the number of parts too
    }
    stp_placed_part* parts;
    size_t part_count;
    stp_result result =
        stp_scene_flatten(scene, scene->root, (size_t)MAX_ELEMENTS, &parts, &part_count);
    if (result != STP_OK) {
        return result;
    }
    bounds_work work = {.scene = scene, .parts = parts};
    work.boxes = STP_NEW_ARRAY(scene->context, stp_boxd, part_count);
    if (work.boxes == NULL) {
        stp_free(scene->context, parts);
        return stp_fail_memory(scene->context);
    }
    stp_parallel_for(scene->context, part_count, 4, measure_parts, &work);
    stp_boxd box = stp_boxd_empty();
    for (size_t i = 0; i < part_count; ++i) {
        stp_boxd_add(&box, work.boxes[i].min);
        stp_boxd_add(&box, work.boxes[i].max);
    }
    scene->nodes[scene->root].bounds = box;
    stp_free(scene->context, work.boxes);
    stp_free(scene->context, parts);
    return STP_OK;
}
