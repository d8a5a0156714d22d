// SPDX-License-Identifier: MIT
#include "base/core/saturate.h"
#include "scene/finish_steps.h"

#include <assert.h>

static stp_vec3d vertex_of(const stp_mesh* mesh, size_t corner)
{
    const float* p = mesh->positions + 3 * (size_t)mesh->indices[corner];
    return (stp_vec3d){(double)p[0], (double)p[1], (double)p[2]};
}

void stp_mesh_measure(stp_mesh* mesh)
{
    stp_boxd box = stp_boxd_empty();
    double area = 0.0;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i += 3) {
        stp_vec3d a = vertex_of(mesh, i), b = vertex_of(mesh, i + 1), c = vertex_of(mesh, i + 2);
        stp_boxd_add(&box, a);
        stp_boxd_add(&box, b);
        stp_boxd_add(&box, c);
        stp_vec3d normal = stp_crossd(stp_subd(b, a), stp_subd(c, a));
        area += 0.5 * sqrt(stp_dotd(normal, normal));
    }
    mesh->area = area;
    mesh->bounds = stp_box_empty();
    if (mesh->triangle_count > 0) { // the coordinates are floats: no rounding
        mesh->bounds = (stp_box){{(float)box.min.x, (float)box.min.y, (float)box.min.z},
                                 {(float)box.max.x, (float)box.max.y, (float)box.max.z}};
    }
}

void stp_node_measure(const stp_scene* scene, stp_node* node)
{
    node->bounds = stp_boxd_empty();
    node->triangle_count = 0;
    node->point_count = 0;
    node->area = 0.0;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_part part = scene->node_parts[node->first_part + i];
        const stp_mesh* mesh = part.kind == STP_PART_MESH ? &scene->meshes[part.index] : NULL;
        stp_box box = mesh != NULL ? mesh->bounds : scene->point_sets[part.index].bounds;
        uint64_t points = mesh != NULL ? 0 : scene->point_sets[part.index].point_count;
        node->triangle_count =
            stp_add_saturated(node->triangle_count, mesh != NULL ? mesh->triangle_count : 0);
        node->point_count = stp_add_saturated(node->point_count, points);
        node->area += mesh != NULL ? mesh->area : 0.0;
        stp_boxd_add(&node->bounds, stp_to_double(box.min));
        stp_boxd_add(&node->bounds, stp_to_double(box.max));
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_edge* edge = &scene->edges[node->first_edge + i];
        assert(edge->node < scene->node_count);
        const stp_node* child = &scene->nodes[edge->node];
        stp_boxd box = stp_affine_box(&edge->transform, child->bounds);
        node->triangle_count = stp_add_saturated(node->triangle_count, child->triangle_count);
        node->point_count = stp_add_saturated(node->point_count, child->point_count);
        node->area += child->area * stp_affine_area_scale(&edge->transform);
        stp_boxd_add(&node->bounds, box.min);
        stp_boxd_add(&node->bounds, box.max);
    }
}
