// SPDX-License-Identifier: MIT
// Decodes a coded mesh into plain arrays, for tools and tests.
#include "base/core/context.h"
#include "store/bytes/format.h"
#include "store/clusters/clusters.h"

#include <assert.h>

static void decode_triangle(const stp_clusters* clusters, const stp_cluster* cluster,
                            uint32_t triangle, stp_decoded_mesh* mesh)
{
    size_t at = (size_t)cluster->first_triangle + triangle;
    assert(at < mesh->triangle_count && "also if the mapped file was overwritten");
    uint32_t corner[3];
    stp_cluster_corners(cluster, triangle, corner);
    stp_vec3 p[3], n[3];
    for (int k = 0; k < 3; ++k) {
        p[k] = stp_cluster_position(clusters, cluster, corner[k]);
    }
    if (!stp_cluster_normals(cluster, triangle, n)) {
        n[0] = n[1] = n[2] = stp_cross(stp_sub(p[1], p[0]), stp_sub(p[2], p[0]));
    }
    for (size_t k = 0; k < 3; ++k) {
        stp_vec3 unit = stp_normalize(n[k]);
        memcpy(mesh->positions + 9 * at + 3 * k, &p[k], sizeof(p[k]));
        memcpy(mesh->normals + 9 * at + 3 * k, &unit, sizeof(unit));
        for (uint32_t set = 0; set < 2; ++set) {
            if (mesh->texcoords[set] != NULL) {
                stp_vec2 uv = stp_cluster_texcoord(clusters, cluster, set, corner[k]);
                memcpy(mesh->texcoords[set] + 6 * at + 2 * k, &uv, sizeof(uv));
            }
        }
        if (mesh->colors != NULL) {
            stp_cluster_color(cluster, corner[k], mesh->colors + 12 * at + 4 * k);
        }
    }
}

stp_result stp_clusters_decode(stp_context* context, const stp_clusters* clusters,
                               stp_decoded_mesh* mesh)
{
    size_t count = (size_t)clusters->triangle_count + 1; // at least one element
    *mesh = (stp_decoded_mesh){.triangle_count = clusters->triangle_count};
    mesh->positions = stp_alloc_array(context, count, 9 * sizeof(float));
    mesh->normals = stp_alloc_array(context, count, 9 * sizeof(float));
    bool made = mesh->positions != NULL && mesh->normals != NULL;
    static const uint32_t columns[2] = {STP_COLUMN_TEXCOORDS_0, STP_COLUMN_TEXCOORDS_1};
    for (int set = 0; set < 2; ++set) {
        if (made && (clusters->present & columns[set]) != 0) {
            mesh->texcoords[set] = stp_alloc_array(context, count, 6 * sizeof(float));
            made = mesh->texcoords[set] != NULL;
        }
    }
    if (made && (clusters->present & STP_COLUMN_COLORS) != 0) {
        mesh->colors = stp_alloc_array(context, count, 12 * sizeof(float));
        made = mesh->colors != NULL;
    }
    if (!made) {
        stp_decoded_mesh_destroy(context, mesh);
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        stp_cluster cluster;
        stp_clusters_get(clusters, i, &cluster);
        for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
            decode_triangle(clusters, &cluster, t, mesh);
        }
    }
    return STP_OK;
}

void stp_decoded_mesh_destroy(stp_context* context, stp_decoded_mesh* mesh)
{
    stp_free(context, mesh->positions);
    stp_free(context, mesh->normals);
    stp_free(context, mesh->texcoords[0]);
    stp_free(context, mesh->texcoords[1]);
    stp_free(context, mesh->colors);
    *mesh = (stp_decoded_mesh){0};
}
