// SPDX-License-Identifier: MIT
#include "builder/stored_levels.h"

#include "base/io/bytes.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { KIND = 3, HEAD = 64, GROUP = 20, CLUSTER = 12, LEVEL = 64, ALIGNMENT = 64 };

static size_t align(size_t size)
{
    return (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

static size_t clusters_at(uint32_t groups)
{
    return HEAD + GROUP * (size_t)groups;
}

static size_t levels_at(uint32_t groups, uint32_t clusters)
{
    return align(clusters_at(groups) + CLUSTER * (size_t)clusters);
}

stp_stored_level stp_stored_level_at(const stp_stored_levels* levels, uint32_t index)
{
    assert(index < levels->level_count);
    const unsigned char* at = levels->levels + LEVEL * (size_t)index;
    float box[6];
    for (int k = 0; k < 6; ++k) {
        box[k] = stp_read_f32(at + 16 + 4 * k);
    }
    return (stp_stored_level){
        .shading = (uint8_t)stp_read_u32(at),
        .area = (double)stp_read_f32(at + 56),
        .coded = {.bytes = levels->groups - HEAD + stp_read_u64(at + 40),
                  .size = (size_t)stp_read_u64(at + 48),
                  .cluster_count = stp_read_u32(at + 4),
                  .triangle_count = stp_read_u32(at + 8),
                  .vertex_count = stp_read_u32(at + 12),
                  .bounds = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}}},
    };
}

void stp_stored_level_group(const stp_stored_levels* levels, uint32_t index, float group[5])
{
    assert(index < levels->group_count);
    for (size_t k = 0; k < 5; ++k) {
        group[k] = stp_read_f32(levels->groups + GROUP * (size_t)index + 4 * k);
    }
}

void stp_stored_level_cluster(const stp_stored_levels* levels, uint32_t index, uint32_t cluster[3])
{
    assert(index < levels->cluster_count);
    for (size_t k = 0; k < 3; ++k) {
        cluster[k] = stp_read_u32(levels->clusters + CLUSTER * (size_t)index + 4 * k);
    }
}

/// Whether a writer accepts the groups.
static bool are_groups_valid(const stp_stored_levels* levels)
{
    bool good = true;
    for (uint32_t i = 0; i < levels->group_count; ++i) {
        float group[5];
        stp_stored_level_group(levels, i, group);
        good = good && group[3] >= 0.0f && group[4] > 0.0f;
        for (int k = 0; k < 5; ++k) {
            good = good && isfinite(group[k]);
        }
    }
    return good;
}

/// Whether a writer accepts the clusters of a level, the first of which is cluster `first`.
static bool are_clusters_valid(const stp_stored_levels* levels, const stp_clusters* coded,
                               uint32_t first)
{
    bool good = true;
    for (uint32_t i = 0; i < coded->cluster_count && good; ++i) {
        uint32_t cluster[3];
        float made[5] = {0}, used[5] = {0};
        stp_stored_level_cluster(levels, first + i, cluster);
        for (int k = 0; k < 2; ++k) {
            good = good && (cluster[k] == STP_LEVEL_NONE || cluster[k] < levels->group_count);
        }
        if (good && cluster[0] != STP_LEVEL_NONE && cluster[1] != STP_LEVEL_NONE) {
            stp_stored_level_group(levels, cluster[0], made);
            stp_stored_level_group(levels, cluster[1], used);
            good = made[4] < used[4];
        }
        good = good && cluster[2] <= stp_clusters_triangles(coded, i);
    }
    return good;
}

/// Whether the levels lie within their bytes, and a writer accepts them.
static bool is_valid(const stp_stored_levels* levels, size_t size, uint32_t shading_count)
{
    uint64_t clusters = 0;
    bool good = are_groups_valid(levels);
    for (uint32_t i = 0; i < levels->level_count; ++i) {
        const unsigned char* at = levels->levels + LEVEL * (size_t)i;
        uint64_t offset = stp_read_u64(at + 40), length = stp_read_u64(at + 48);
        if (offset > size || length > size - offset || offset % ALIGNMENT != 0) {
            return false;
        }
        stp_stored_level level = stp_stored_level_at(levels, i);
        stp_clusters open;
        if (stp_clusters_open(level.coded.bytes, level.coded.size, &open) != NULL ||
            open.cluster_count != level.coded.cluster_count ||
            open.triangle_count != level.coded.triangle_count ||
            open.vertex_count != level.coded.vertex_count || level.shading >= shading_count ||
            open.cluster_count > levels->cluster_count - clusters) {
            return false;
        }
        good = good && are_clusters_valid(levels, &open, (uint32_t)clusters);
        clusters += open.cluster_count;
    }
    return good && clusters == levels->cluster_count;
}

static bool open_levels(const unsigned char* bytes, size_t size, uint32_t shading_count,
                        stp_stored_levels* levels)
{
    *levels = (stp_stored_levels){0};
    if (size < HEAD || stp_read_u32(bytes) != KIND) {
        return false;
    }
    levels->level_count = stp_read_u32(bytes + 4);
    levels->group_count = stp_read_u32(bytes + 8);
    levels->cluster_count = stp_read_u32(bytes + 12);
    levels->from_outside = stp_read_u32(bytes + 16) != 0;
    size_t at = levels_at(levels->group_count, levels->cluster_count);
    levels->groups = bytes + HEAD;
    levels->clusters = bytes + clusters_at(levels->group_count);
    levels->levels = bytes + at;
    return at <= size && LEVEL * (size_t)levels->level_count <= size - at &&
           is_valid(levels, size, shading_count);
}

bool stp_work_find_levels(stp_work* work, stp_hash key, uint32_t shading_count,
                          stp_stored_levels* levels)
{
    size_t size = 0;
    const unsigned char* bytes = stp_work_find(work, key, &size);
    if (bytes == NULL) {
        return false;
    }
    if (!open_levels(bytes, size, shading_count, levels)) {
        stp_work_drop(work, key);
        return false;
    }
    return true;
}

stp_hash stp_level_key(stp_hash key, uint32_t index, uint8_t shading)
{
    key = stp_hash_bytes(key, &index, sizeof(index));
    return stp_hash_bytes(key, &shading, sizeof(shading));
}

static stp_result code_level(stp_context* context, const stp_node_level* level, double step,
                             stp_coded_mesh* coded)
{
    const stp_store_mesh mesh = {.vertex_count = level->vertex_count,
                                 .triangle_count = level->triangle_count,
                                 .positions = level->positions,
                                 .colors = level->colors,
                                 .indices = level->indices};
    uint32_t* ends = STP_NEW_ARRAY(context, uint32_t, (size_t)level->cluster_count + 1);
    if (ends == NULL) {
        *coded = (stp_coded_mesh){0};
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < level->cluster_count; ++i) {
        ends[i] = level->clusters[i].end;
    }
    stp_result result =
        stp_clusters_encode_ranges(context, &mesh, step, ends, level->cluster_count, coded);
    stp_free(context, ends);
    return result;
}

/// The area of a coded mesh: the same from whichever build its bytes come.
static double coded_area(const stp_coded_mesh* coded)
{
    stp_clusters clusters;
    double area = 0.0;
    if (stp_clusters_open(coded->bytes, coded->size, &clusters) != NULL) {
        return 0.0;
    }
    for (uint32_t i = 0; i < clusters.cluster_count; ++i) {
        stp_cluster cluster;
        float p[3 * STP_CLUSTER_VERTICES];
        stp_clusters_get(&clusters, i, &cluster);
        stp_cluster_positions(&clusters, &cluster, p);
        for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
            uint32_t c[3];
            stp_vec3d at[3];
            stp_cluster_corners(&cluster, t, c);
            for (int k = 0; k < 3; ++k) {
                const float* from = p + 3 * (size_t)c[k];
                at[k] = (stp_vec3d){(double)from[0], (double)from[1], (double)from[2]};
            }
            stp_vec3d n = stp_crossd(stp_subd(at[1], at[0]), stp_subd(at[2], at[0]));
            area += 0.5 * sqrt(stp_dotd(n, n));
        }
    }
    return area;
}

static void write_level(unsigned char* at, const stp_node_level* level, const stp_coded_mesh* coded,
                        size_t offset)
{
    stp_write_u32(at, level->shading);
    stp_write_u32(at + 4, coded->cluster_count);
    stp_write_u32(at + 8, coded->triangle_count);
    stp_write_u32(at + 12, coded->vertex_count);
    const float box[6] = {coded->bounds.min.x, coded->bounds.min.y, coded->bounds.min.z,
                          coded->bounds.max.x, coded->bounds.max.y, coded->bounds.max.z};
    for (int k = 0; k < 6; ++k) {
        stp_write_f32(at + 16 + 4 * k, box[k]);
    }
    stp_write_u64(at + 40, offset);
    stp_write_u64(at + 48, coded->size);
    stp_write_f32(at + 56, (float)coded_area(coded));
}

/// Fills the bytes before the coded meshes.
static void write_tables(const stp_node_levels* levels, const stp_coded_mesh* coded,
                         uint32_t clusters, unsigned char* bytes)
{
    stp_write_u32(bytes, KIND);
    stp_write_u32(bytes + 4, levels->level_count);
    stp_write_u32(bytes + 8, levels->group_count);
    stp_write_u32(bytes + 12, clusters);
    stp_write_u32(bytes + 16, levels->from_outside ? 1 : 0);
    for (uint32_t i = 0; i < levels->group_count; ++i) {
        const stp_level_group* g = &levels->groups[i];
        const float numbers[5] = {(float)g->center.x, (float)g->center.y, (float)g->center.z,
                                  (float)g->radius, (float)g->error};
        for (size_t k = 0; k < 5; ++k) {
            stp_write_f32(bytes + HEAD + GROUP * (size_t)i + 4 * k, numbers[k]);
        }
    }
    unsigned char* at = bytes + clusters_at(levels->group_count);
    size_t offset =
        align(levels_at(levels->group_count, clusters) + LEVEL * (size_t)levels->level_count);
    for (uint32_t i = 0; i < levels->level_count; ++i) {
        const stp_node_level* level = &levels->levels[i];
        for (uint32_t k = 0; k < level->cluster_count; ++k, at += CLUSTER) {
            stp_write_u32(at, level->clusters[k].made_by);
            stp_write_u32(at + 4, level->clusters[k].used_by);
            stp_write_u32(at + 8, level->clusters[k].one_sided);
        }
        write_level(bytes + levels_at(levels->group_count, clusters) + LEVEL * (size_t)i, level,
                    &coded[i], offset);
        memcpy(bytes + offset, coded[i].bytes, coded[i].size);
        offset = align(offset + coded[i].size);
    }
}

stp_result stp_work_store_coded_levels(stp_context* context, stp_work* work, stp_hash key,
                                       const stp_node_levels* levels, const stp_coded_mesh* coded)
{
    uint32_t clusters = 0;
    for (uint32_t i = 0; i < levels->level_count; ++i) {
        clusters += levels->levels[i].cluster_count;
    }
    size_t size =
        align(levels_at(levels->group_count, clusters) + LEVEL * (size_t)levels->level_count);
    for (uint32_t i = 0; i < levels->level_count; ++i) {
        size += align(coded[i].size);
    }
    unsigned char* bytes = stp_alloc_zeroed(context, size, 1);
    if (bytes == NULL) {
        return stp_fail_memory(context);
    }
    write_tables(levels, coded, clusters, bytes);
    const stp_bytes part = {bytes, size};
    stp_result result = stp_work_store(work, key, &part, 1, NULL);
    stp_free(context, bytes);
    return result;
}

stp_result stp_work_store_levels(stp_context* context, stp_work* work, stp_hash key,
                                 const stp_node_levels* levels)
{
    stp_coded_mesh* coded =
        STP_NEW_ZEROED(context, stp_coded_mesh, (size_t)levels->level_count + 1);
    stp_result result = coded != NULL ? STP_OK : stp_fail_memory(context);
    for (uint32_t i = 0; i < levels->level_count && result == STP_OK; ++i) {
        result = code_level(context, &levels->levels[i], levels->step, &coded[i]);
    }
    result =
        result == STP_OK ? stp_work_store_coded_levels(context, work, key, levels, coded) : result;
    for (uint32_t i = 0; i < levels->level_count && coded != NULL; ++i) {
        stp_coded_mesh_destroy(context, &coded[i]);
    }
    stp_free(context, coded);
    return result;
}
