// SPDX-License-Identifier: MIT
// The content of a file for the search of farthest points.
#include "select/farthest.h"
#include "store/file/instances.h"
#include "store/residency/residency.h"

#include <assert.h>
#include <math.h>

enum {
    NODE, ///< kinds of items
    MESH,
    POINTS,
};

/// Strays are at most one of so many points, or one of as many as STRAY_POINTS, and make a cloud so
/// many times as large.
enum { STRAY_SHARE = 32, STRAY_POINTS = 8, STRAY_SIZE = 8 };

static uint32_t count_children(const void* user, const stp_farthest_item* node)
{
    const stp_farthest_store* content = user;
    const stp_store_node* n = &stp_store_get_directory(content->store)->nodes[node->index];
    return n->edge_count + n->part_count;
}

static bool get_child(const void* user, const stp_farthest_item* node, uint32_t i,
                      stp_farthest_item* child)
{
    const stp_farthest_store* content = user;
    const stp_store_directory* d = stp_store_get_directory(content->store);
    const stp_store_node* n = &d->nodes[node->index];
    uint32_t state = stp_show_of(node->state) == STP_SHOW_MIXED
                         ? stp_visibility_below(content->visibility, node->state, i)
                         : node->state;
    if (stp_show_of(state) == STP_SHOW_NOT) {
        return false;
    }
    if (i < n->edge_count) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        *child =
            (stp_farthest_item){.kind = NODE,
                                .index = edge->node,
                                .transform = stp_affine_multiply(node->transform, edge->transform),
                                .bounds = d->nodes[edge->node].bounds};
    } else {
        stp_store_part part = d->parts[n->first_part + i - n->edge_count];
        stp_instance spot = stp_instance_of_part(content->store, part, &node->transform);
        *child = (stp_farthest_item){.is_part = true,
                                     .kind = part.kind == STP_STORE_PART_MESH ? MESH : POINTS,
                                     .index = part.index,
                                     .transform = node->transform,
                                     .bounds = spot.bounds};
    }
    child->state = state;
    return true;
}

/// Whether a cluster's box reaches farther.
static bool reaches(stp_box box, stp_vec3d d, double farthest)
{
    double x = (double)(d.x > 0.0 ? box.max.x : box.min.x);
    double y = (double)(d.y > 0.0 ? box.max.y : box.min.y);
    double z = (double)(d.z > 0.0 ? box.max.z : box.min.z);
    return d.x * x + d.y * y + d.z * z > farthest;
}

static bool measure_mesh(stp_store* store, uint32_t index, stp_vec3d direction, double* farthest,
                         stp_vec3d* point)
{
    stp_clusters clusters;
    stp_store_mesh mesh;
    if (!stp_store_is_clustered(store, index)) {
        if (stp_store_get_mesh(store, index, &mesh) != STP_OK) {
            return false;
        }
        stp_farthest_vertex(mesh.positions, mesh.vertex_count, direction, farthest, point);
        return true;
    }
    if (stp_store_get_clusters(store, index, &clusters) != STP_OK) {
        return false;
    }
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        if (reaches(stp_clusters_bounds(&clusters, i), direction, *farthest)) {
            stp_cluster cluster;
            float positions[3 * STP_CLUSTER_VERTICES];
            stp_clusters_get(&clusters, i, &cluster);
            stp_cluster_positions(&clusters, &cluster, positions);
            stp_farthest_vertex(positions, cluster.vertex_count, direction, farthest, point);
        }
    }
    return true;
}

static bool measure_points(stp_store* store, uint32_t index, stp_vec3d direction, double* farthest,
                           stp_vec3d* point)
{
    stp_store_point_set points = *stp_store_describe_point_set(store, index);
    stp_splats set = {0};
    if (points.held_by == 0) {
        if (stp_store_get_point_set(store, index, &points) != STP_OK) {
            return false;
        }
        stp_farthest_vertex(points.positions, points.point_count, direction, farthest, point);
        return true;
    }
    if (stp_store_get_splat_set(store, points.held_by - 1, &set) != STP_OK ||
        set.count < points.point_count) { // in a partial file
        return false;
    }
    for (uint32_t i = 0; i < set.count; ++i) {
        stp_vec3d place = stp_splat_place(&set, i);
        double reach = stp_dotd(direction, place);
        if (reach > *farthest) {
            *farthest = reach;
            *point = place;
        }
    }
    return true;
}

static bool measure_part(const void* user, const stp_farthest_item* part, stp_vec3d direction,
                         stp_vec3d* point)
{
    const stp_farthest_store* content = user;
    stp_store* store = content->store;
    bool held =
        part->kind == POINTS && stp_store_describe_point_set(store, part->index)->held_by != 0;
    bool resident = part->kind == MESH ? stp_store_is_mesh_resident(store, part->index)
                                       : stp_store_are_points_resident(store, part->index);
    double farthest = -HUGE_VAL;
    assert(part->is_part && part->kind != NODE);
    if (!resident && !held) {
        return false;
    }
    // drawing reports what cannot be read
    stp_hold_errors(content->context);
    bool read = part->kind == MESH
                    ? measure_mesh(store, part->index, direction, &farthest, point)
                    : measure_points(store, part->index, direction, &farthest, point);
    stp_release_errors(content->context, false);
    return read && farthest > -HUGE_VAL;
}

static double longest_side(const stp_farthest_item* item)
{
    stp_boxd box = stp_affine_box(&item->transform, item->bounds);
    stp_vec3d side = stp_subd(box.max, box.min);
    return fmax(fmax(side.x, side.y), side.z);
}

/// The node below that holds all triangles and nearly all points, if points far from these make the
/// whole much larger: strays, which a build puts into nodes of their own (scene/strays.h).
static stp_farthest_item without_strays(const stp_farthest_store* content,
                                        const stp_farthest_item* whole)
{
    const stp_store_directory* d = stp_store_get_directory(content->store);
    uint64_t triangles = d->nodes[whole->index].triangle_count;
    uint64_t points = d->nodes[whole->index].point_count;
    uint64_t strays = points / STRAY_SHARE > 0 ? points / STRAY_SHARE : 1;
    stp_farthest_item rest = *whole;
    for (bool deeper = points >= STRAY_POINTS; deeper;) {
        uint32_t edges = d->nodes[rest.index].edge_count;
        deeper = false;
        for (uint32_t i = 0; i < edges && !deeper; ++i) {
            stp_farthest_item child;
            bool shown = get_child(content, &rest, i, &child);
            const stp_store_node* n = shown ? &d->nodes[child.index] : NULL;
            deeper = shown && n->triangle_count == triangles && n->point_count + strays >= points;
            rest = deeper ? child : rest;
        }
    }
    return longest_side(whole) >= STRAY_SIZE * longest_side(&rest) ? rest : *whole;
}

bool stp_farthest_begin(const stp_farthest_store* content, const stp_placed_node* placed,
                        stp_farthest_graph* graph)
{
    const stp_store_directory* d = stp_store_get_directory(content->store);
    uint32_t node = placed != NULL ? placed->node : d->root;
    if (node == STP_STORE_NONE) {
        return false;
    }
    assert(node < d->node_count);
    bool marked = placed == NULL && content->visibility != NULL;
    *graph = (stp_farthest_graph){
        .user = content,
        .root = {.kind = NODE,
                 .index = node,
                 .state = marked ? stp_visibility_root(content->visibility) : STP_SHOW,
                 .transform = placed != NULL ? placed->transform : stp_affine_identity(),
                 .bounds = d->nodes[node].bounds},
        .count = count_children,
        .get = get_child,
        .measure = measure_part};
    bool shown = stp_show_of(graph->root.state) != STP_SHOW_NOT;
    graph->root = shown ? without_strays(content, &graph->root) : graph->root;
    return shown;
}
