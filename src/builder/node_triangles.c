// SPDX-License-Identifier: MIT
#include "base/splats/splat_columns.h"
#include "base/splats/triangle_level.h"
#include "builder/method_sets.h"

#include <assert.h>
#include <string.h>

typedef struct walk {
    const stp_scene* scene;
    double level;   ///< only triangles above this level
    uint64_t count; ///< triangles so far
    float* corners; ///< NULL: only count
    uint32_t left;  ///< parts and nodes that may still be visited
} walk;

static void visit_mesh(walk* w, const stp_mesh* mesh, const stp_affine* below)
{
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        float p[9];
        for (size_t k = 0; k < 3; ++k) {
            assert(mesh->indices[3 * i + k] < mesh->vertex_count);
            const float* at = mesh->positions + 3 * (size_t)mesh->indices[3 * i + k];
            stp_vec3d placed =
                stp_affine_point(below, (stp_vec3d){(double)at[0], (double)at[1], (double)at[2]});
            p[3 * k] = (float)placed.x;
            p[3 * k + 1] = (float)placed.y;
            p[3 * k + 2] = (float)placed.z;
        }
        float level = stp_triangle_level((stp_vec3){p[0], p[1], p[2]}, (stp_vec3){p[3], p[4], p[5]},
                                         (stp_vec3){p[6], p[7], p[8]});
        if ((double)level > w->level && level < HUGE_VALF) {
            if (w->corners != NULL) {
                memcpy(w->corners + 9 * w->count, p, sizeof(p));
            }
            w->count += 1;
        }
    }
}

static void visit_node(walk* w, uint32_t index, const stp_affine* below)
{
    const stp_node* node = &w->scene->nodes[index];
    for (uint32_t i = 0; i < node->part_count && w->left > 0; ++i) {
        stp_part part = w->scene->node_parts[node->first_part + i];
        w->left -= 1;
        if (part.kind != STP_PART_MESH) {
            continue;
        }
        const stp_mesh* mesh = &w->scene->meshes[part.index];
        stp_vec3d size = stp_subd(stp_to_double(mesh->bounds.max), stp_to_double(mesh->bounds.min));
        double scale = stp_affine_scale(below);
        double maximum = 0.5 * scale * sqrt(size.x * size.x + size.y * size.y + size.z * size.z);
        if (maximum > w->level &&
            w->scene->materials[mesh->material].alpha_mode == STP_ALPHA_OPAQUE) {
            visit_mesh(w, mesh, below);
        }
    }
    for (uint32_t i = 0; i < node->edge_count && w->left > 0; ++i) {
        const stp_edge* edge = &w->scene->edges[node->first_edge + i];
        stp_affine transform = stp_affine_multiply(*below, edge->transform);
        w->left -= 1;
        if ((w->scene->nodes[edge->node].flags & STP_OBJECT_MOVING) == 0) {
            visit_node(w, edge->node, &transform);
        }
    }
}

static uint32_t visit_subtree(const stp_scene* scene, uint32_t node, double level, float* corners)
{
    walk w = {.scene = scene, .level = level, .corners = corners, .left = STP_LARGE_USES + 1};
    stp_affine here = stp_affine_identity();
    visit_node(&w, node, &here);
    return w.left > 0 && w.count < UINT32_MAX / 2 ? (uint32_t)w.count : 0;
}

uint32_t stp_count_node_triangles(const stp_scene* scene, uint32_t node, double level)
{
    return visit_subtree(scene, node, level, NULL);
}

stp_result stp_take_node_triangles(const stp_scene* scene, uint32_t node, double level,
                                   uint32_t count, stp_node_triangles* triangles)
{
    *triangles = (stp_node_triangles){
        .corners = STP_NEW_ARRAY(scene->context, float, 9 * (size_t)count + 1)};
    if (triangles->corners == NULL) {
        return stp_fail_memory(scene->context);
    }
    triangles->count = count > 0 ? visit_subtree(scene, node, level, triangles->corners) : 0;
    assert(triangles->count == count && "listed as counted: more would not fit");
    return STP_OK;
}

void stp_node_triangles_destroy(stp_context* context, stp_node_triangles* triangles)
{
    stp_free(context, triangles->corners);
    *triangles = (stp_node_triangles){0};
}
