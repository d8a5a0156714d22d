// SPDX-License-Identifier: MIT
// Looks up single triangles, from columns or clusters.
#include "draw/cpu/triangle.h"

#include <assert.h>
#include <string.h>

stp_vec3 stp_cpu_decode_normal(const int16_t* code)
{
    float u = (float)code[0] * (1.0f / 32767.0f), v = (float)code[1] * (1.0f / 32767.0f);
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u += u >= 0.0f ? -fold : fold;
    v += v >= 0.0f ? -fold : fold;
    return (stp_vec3){u, v, z};
}

static void set_position(const stp_cpu_item* item, const float* p, float out[3])
{
    for (int c = 0; c < 3; ++c) {
        out[c] = p[c] - item->offset[c];
    }
}

static void read_columns(const stp_cpu_item* item, uint32_t index, stp_cpu_triangle* out)
{
    const stp_store_mesh* mesh = &item->mesh;
    out->has_normal = mesh->normals != NULL;
    out->has_color = mesh->colors != NULL;
    for (size_t k = 0; k < 3; ++k) {
        size_t v = stp_store_mesh_corner(mesh, 3 * (size_t)index + k);
        set_position(item, mesh->positions + 3 * v, out->position[k]);
        if (out->has_normal) {
            out->normal[k] = stp_cpu_decode_normal(mesh->normals + 2 * v);
        }
        for (int c = 0; c < 4 && out->has_color; ++c) {
            out->color[k][c] = (float)mesh->colors[4 * v + (size_t)c] * (1.0f / 65535.0f);
        }
    }
    for (int set = 0; set < 2; ++set) {
        out->has_texcoord[set] = item->reads_texcoords[set] && mesh->texcoords[set] != NULL;
        for (size_t k = 0; k < 3 && out->has_texcoord[set]; ++k) {
            size_t v = stp_store_mesh_corner(mesh, 3 * (size_t)index + k);
            memcpy(out->texcoord[set][k], mesh->texcoords[set] + 2 * v,
                   sizeof(out->texcoord[0][0]));
        }
    }
}

static void open_cluster(stp_cpu_reader* reader, const stp_cpu_item* item, uint32_t index)
{
    const stp_cluster* open = &reader->cluster;
    if (reader->cluster_item != item || index < open->first_triangle ||
        index - open->first_triangle >= open->triangle_count) {
        stp_clusters_get(&item->clusters, stp_clusters_find(&item->clusters, index),
                         &reader->cluster);
        reader->cluster_item = item;
    }
}

void stp_cpu_read_from_cluster(const stp_cpu_item* item, const stp_cluster* cluster, uint32_t index,
                               stp_cpu_triangle* out)
{
    const stp_clusters* clusters = &item->clusters;
    uint32_t local = index - cluster->first_triangle;
    uint32_t corner[3];
    stp_cluster_corners(cluster, local, corner);
    out->has_normal = stp_cluster_normals(cluster, local, out->normal);
    out->has_color = (clusters->present & STP_COLUMN_COLORS) != 0;
    for (int k = 0; k < 3; ++k) {
        stp_vec3 p = stp_cluster_position(clusters, cluster, corner[k]);
        set_position(item, (const float[3]){p.x, p.y, p.z}, out->position[k]);
        if (out->has_color) {
            stp_cluster_color(cluster, corner[k], out->color[k]);
        }
    }
    static const uint32_t columns[2] = {STP_COLUMN_TEXCOORDS_0, STP_COLUMN_TEXCOORDS_1};
    for (uint32_t set = 0; set < 2; ++set) {
        out->has_texcoord[set] =
            item->reads_texcoords[set] && (clusters->present & columns[set]) != 0;
        for (int k = 0; k < 3 && out->has_texcoord[set]; ++k) {
            stp_vec2 uv = stp_cluster_texcoord(clusters, cluster, set, corner[k]);
            out->texcoord[set][k][0] = uv.x;
            out->texcoord[set][k][1] = uv.y;
        }
    }
}

const stp_cpu_triangle* stp_cpu_read_triangle(stp_cpu_reader* reader, const stp_cpu_item* item,
                                              uint32_t index)
{
    assert(item->kind == STP_DRAW_MESH && "points have no triangles");
    if (reader->item == item && reader->index == index) {
        return &reader->triangle;
    }
    reader->item = item;
    reader->index = index;
    if (item->clusters.bytes != NULL) {
        open_cluster(reader, item, index);
        stp_cpu_read_from_cluster(item, &reader->cluster, index, &reader->triangle);
    } else {
        read_columns(item, index, &reader->triangle);
    }
    return &reader->triangle;
}
