// SPDX-License-Identifier: MIT
#include "store/file/instances.h"

#include <assert.h>

#define SAME_PART 1e-6   // relative to the object's diagonal
#define SAME_ROUND 1e-11 // relative to its coordinates

static stp_vec3d middle_of(const stp_boxd* box)
{
    return stp_addd(box->min, stp_scaled(stp_subd(box->max, box->min), 0.5));
}

static double largest_of(stp_vec3d v)
{
    return fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
}

stp_instance stp_instance_of_node(const stp_store* store, uint32_t node,
                                  const stp_affine* transform)
{
    assert(node < stp_store_get_directory(store)->node_count);
    stp_instance instance = {.node = node, .transform = *transform};
    instance.bounds = stp_store_get_directory(store)->nodes[node].bounds;
    instance.center = stp_affine_point(transform, middle_of(&instance.bounds));
    return instance;
}

stp_instance stp_instance_of_part(const stp_store* store, stp_store_part part,
                                  const stp_affine* transform)
{
    stp_instance instance = {.is_part = true, .part = part, .transform = *transform};
    stp_box box = part.kind == STP_STORE_PART_MESH
                      ? stp_store_describe_mesh(store, part.index)->bounds
                      : stp_store_describe_point_set(store, part.index)->bounds;
    instance.bounds = (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)};
    instance.center = stp_affine_point(transform, middle_of(&instance.bounds));
    return instance;
}

bool stp_instance_is_same(const stp_boxd* bounds, const stp_affine* a, const stp_affine* b)
{
    stp_vec3d size = stp_subd(bounds->max, bounds->min);
    const stp_vec3d corners[4] = {
        bounds->min,
        stp_addd(bounds->min, (stp_vec3d){size.x, 0, 0}),
        stp_addd(bounds->min, (stp_vec3d){0, size.y, 0}),
        stp_addd(bounds->min, (stp_vec3d){0, 0, size.z}),
    };
    stp_vec3d first = stp_affine_point(a, corners[0]);
    double width = 0.0, apart = 0.0, maximum = largest_of(first);
    for (int k = 0; k < 4; ++k) {
        stp_vec3d p = stp_affine_point(a, corners[k]), q = stp_affine_point(b, corners[k]);
        width = fmax(width, largest_of(stp_subd(p, first)));
        apart = fmax(apart, largest_of(stp_subd(p, q)));
    }
    return apart <= SAME_PART * width + SAME_ROUND * maximum;
}

bool stp_instance_may_hold(const stp_boxd* bounds, const stp_affine* transform, stp_vec3d point)
{
    if (stp_boxd_is_empty(*bounds)) {
        return false;
    }
    stp_vec3d half = stp_scaled(stp_subd(bounds->max, bounds->min), 0.5);
    stp_vec3d from = stp_subd(point, stp_affine_point(transform, middle_of(bounds)));
    const double away[3] = {fabs(from.x), fabs(from.y), fabs(from.z)};
    double rounding = SAME_ROUND * largest_of(point);
    for (int k = 0; k < 3; ++k) {
        const double* row = transform->m[k];
        double reach = fabs(row[0]) * half.x + fabs(row[1]) * half.y + fabs(row[2]) * half.z;
        if (away[k] > reach * (1.0 + SAME_PART) + rounding) {
            return false;
        }
    }
    return true;
}

static bool is_same_part(stp_store_part a, stp_store_part b)
{
    return a.kind == b.kind && a.index == b.index;
}

static bool find_below(stp_instance_search* search, uint32_t node, const stp_affine* transform,
                       const stp_instance* instance, uint32_t depth)
{
    const stp_store_directory* d = search->directory;
    const stp_store_node* n = &d->nodes[node];
    if (search->visits_left == 0 || depth >= STP_INSTANCE_DEPTH) {
        search->gave_up = true;
        return false;
    }
    search->visits_left -= 1;
    if (!instance->is_part && node == instance->node &&
        stp_instance_is_same(&instance->bounds, transform, &instance->transform)) {
        return true;
    }
    for (uint32_t i = 0; instance->is_part && i < n->part_count; ++i) {
        if (is_same_part(d->parts[n->first_part + i], instance->part) &&
            stp_instance_is_same(&instance->bounds, transform, &instance->transform)) {
            return true;
        }
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        assert(edge->node < node && "children have lower indices");
        bool lower =
            !instance->is_part && edge->node < instance->node; // children have lower indices
        if (lower || (search->reaches != NULL && search->reaches[edge->node] == 0)) {
            continue;
        }
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        if (stp_instance_may_hold(&d->nodes[edge->node].bounds, &below, instance->center) &&
            find_below(search, edge->node, &below, instance, depth + 1)) {
            return true;
        }
    }
    return false;
}

bool stp_instance_holds(stp_instance_search* search, uint32_t node, const stp_affine* transform,
                        const stp_instance* instance)
{
    return find_below(search, node, transform, instance, 0);
}
