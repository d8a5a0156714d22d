// SPDX-License-Identifier: MIT
// Finds edges that exist only because faces are triangulated.
#include "select/pick_internal.h"
#include "store/clusters/clusters.h"

#include <assert.h>
#include <string.h>

/// Sine of the maximum angle between coplanar triangles.
#define FLAT 1e-3

static bool is_same(stp_vec3 a, stp_vec3 b)
{
    return memcmp(&a, &b, sizeof(a)) == 0;
}

static stp_vec3d normal_of(const stp_vec3 c[3])
{
    stp_vec3d a = stp_to_double(c[0]);
    return stp_normalized(
        stp_crossd(stp_subd(stp_to_double(c[1]), a), stp_subd(stp_to_double(c[2]), a)));
}

/// Compares a triangle with the picked one.
static void compare(stp_pick* pick, const stp_vec3 picked[3], const stp_vec3 other[3])
{
    for (int k = 0; k < 3; ++k) {
        int shared = 0;
        for (int i = 0; i < 3; ++i) {
            shared +=
                is_same(other[i], picked[k]) || is_same(other[i], picked[(k + 1) % 3]) ? 1 : 0;
        }
        if (shared == 2) {
            stp_vec3d across = stp_crossd(normal_of(picked), normal_of(other));
            double sine = stp_dotd(across, across);
            pick->inner[k] = pick->inner[k] || sine < FLAT * FLAT;
        }
    }
}

static bool may_touch(stp_box box, const stp_vec3 c[3])
{
    stp_box around = stp_box_empty();
    for (int k = 0; k < 3; ++k) {
        stp_box_add(&around, c[k]);
    }
    return box.min.x <= around.max.x && around.min.x <= box.max.x && box.min.y <= around.max.y &&
           around.min.y <= box.max.y && box.min.z <= around.max.z && around.min.z <= box.max.z;
}

static void search_cluster(stp_pick* pick, const stp_clusters* clusters, uint32_t index,
                           uint32_t triangle, const stp_vec3 picked[3])
{
    stp_cluster cluster;
    float positions[3 * STP_CLUSTER_VERTICES];
    stp_clusters_get(clusters, index, &cluster);
    stp_cluster_positions(clusters, &cluster, positions);
    for (uint32_t i = 0; i < cluster.triangle_count; ++i) {
        uint32_t c[3];
        stp_vec3 other[3];
        stp_cluster_corners(&cluster, i, c);
        for (int k = 0; k < 3; ++k) {
            memcpy(&other[k], positions + 3 * (size_t)c[k], sizeof(other[k]));
        }
        if (cluster.first_triangle + i != triangle) {
            compare(pick, picked, other);
        }
    }
}

stp_result stp_pick_find_inner(stp_pick_work* work, uint32_t mesh, uint32_t triangle,
                               const stp_vec3 corners[3])
{
    stp_pick* pick = work->pick;
    assert(pick->hit && pick->part.kind == STP_STORE_PART_MESH && pick->part.index == mesh);
    memset(pick->inner, 0, sizeof(pick->inner));
    if (stp_store_is_clustered(work->store, mesh)) {
        stp_clusters clusters;
        stp_result result = stp_store_get_clusters(work->store, mesh, &clusters);
        for (uint32_t i = 0; result == STP_OK && i < clusters.cluster_count; ++i) {
            if (may_touch(stp_clusters_bounds(&clusters, i), corners)) {
                search_cluster(pick, &clusters, i, triangle, corners);
            }
        }
        return result;
    }
    stp_store_mesh columns;
    stp_result result = stp_store_get_mesh(work->store, mesh, &columns);
    for (uint32_t i = 0; result == STP_OK && i < columns.triangle_count; ++i) {
        stp_vec3 other[3];
        for (size_t k = 0; k < 3; ++k) {
            size_t vertex = stp_store_mesh_corner(&columns, 3 * (size_t)i + k);
            memcpy(&other[k], columns.positions + 3 * vertex, sizeof(other[k]));
        }
        if (i != triangle) {
            compare(pick, corners, other);
        }
    }
    return result;
}
