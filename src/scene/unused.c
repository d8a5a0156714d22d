// SPDX-License-Identifier: MIT
#include "scene/bulk.h"
#include "scene/partition_steps.h"

#include <assert.h>

stp_result stp_find_uses(const stp_scene* scene, const stp_node* nodes, size_t node_count,
                         const stp_part* node_parts, uint8_t** mesh_uses, uint8_t** point_uses)
{
    stp_context* context = scene->context;
    uint8_t* of_meshes = STP_NEW_ZEROED(context, uint8_t, scene->mesh_count);
    uint8_t* of_points = STP_NEW_ZEROED(context, uint8_t, scene->point_set_count);
    if (of_meshes == NULL || of_points == NULL) {
        stp_free(context, of_meshes);
        stp_free(context, of_points);
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < node_count; ++i) {
        bool moving = (nodes[i].flags & STP_OBJECT_MOVING) != 0;
        for (uint32_t k = 0; k < nodes[i].part_count; ++k) {
            stp_part part = node_parts[nodes[i].first_part + k];
            uint8_t* uses = part.kind == STP_PART_MESH ? of_meshes : of_points;
            assert(part.index <
                   (part.kind == STP_PART_MESH ? scene->mesh_count : scene->point_set_count));
            uses[part.index] |= moving ? STP_USED_MOVING : STP_USED_RESTING;
        }
    }
    *mesh_uses = of_meshes;
    *point_uses = of_points;
    return STP_OK;
}

void stp_scene_release(stp_scene* scene, stp_part part)
{
    if (part.kind == STP_PART_MESH) {
        stp_mesh_free_arrays(scene, &scene->meshes[part.index]);
    } else {
        stp_points_free_arrays(scene, &scene->point_sets[part.index]);
    }
}

static void remap_parts(stp_part* parts, size_t count, const uint32_t* meshes,
                        const uint32_t* points)
{
    for (size_t i = 0; i < count; ++i) {
        parts[i].index = (parts[i].kind == STP_PART_MESH ? meshes : points)[parts[i].index];
    }
}

stp_result stp_drop_unused(stp_scene* scene)
{
    stp_context* context = scene->context;
    uint8_t *mesh_uses = NULL, *point_uses = NULL;
    uint32_t* meshes = STP_NEW_ARRAY(context, uint32_t, scene->mesh_count);
    uint32_t* points = STP_NEW_ARRAY(context, uint32_t, scene->point_set_count);
    stp_result result = meshes != NULL && points != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result = stp_find_uses(scene, scene->nodes, scene->node_count, scene->node_parts,
                               &mesh_uses, &point_uses);
    }
    if (result == STP_OK) {
        size_t left = 0;
        for (size_t i = 0; i < scene->mesh_count; ++i) {
            meshes[i] = mesh_uses[i] != 0 ? (uint32_t)left : STP_NONE;
            if (mesh_uses[i] == 0) {
                stp_mesh_free_arrays(scene, &scene->meshes[i]);
            } else {
                scene->meshes[left++] = scene->meshes[i];
            }
        }
        scene->mesh_count = left;
        left = 0;
        for (size_t i = 0; i < scene->point_set_count; ++i) {
            points[i] = point_uses[i] != 0 ? (uint32_t)left : STP_NONE;
            if (point_uses[i] == 0) {
                stp_points_free_arrays(scene, &scene->point_sets[i]);
            } else {
                scene->point_sets[left++] = scene->point_sets[i];
            }
        }
        scene->point_set_count = left;
        remap_parts(scene->node_parts, scene->node_part_count, meshes, points);
        remap_parts(scene->parts, scene->part_count, meshes, points);
    }
    stp_free(context, point_uses);
    stp_free(context, mesh_uses);
    stp_free(context, points);
    stp_free(context, meshes);
    return result;
}
