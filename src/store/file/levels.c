// SPDX-License-Identifier: MIT
// The levels of a directory: links them to their meshes, clusters and groups. The reader and the
// writer check the same.
#include "store/clusters/clusters_layout.h"
#include "store/file/block_order.h"
#include "store/file/block_table.h"
#include "store/file/tables.h"

#include <assert.h>
#include <float.h>

static stp_result check_groups(const stp_store_validator* validator, const stp_store_directory* d)
{
    for (uint32_t i = 0; i < d->level_group_count; ++i) {
        const stp_store_level_group* group = &d->level_groups[i];
        if (!(group->radius >= 0.0f && group->error > 0.0f)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: level group %u: a radius of %g or an error of %g is invalid",
                            validator->path, i, (double)group->radius, (double)group->error);
        }
    }
    return STP_OK;
}

static stp_result check_clusters(const stp_store_validator* validator, const stp_store_directory* d)
{
    for (uint32_t i = 0; i < d->level_cluster_count; ++i) {
        const stp_store_level_cluster* cluster = &d->level_clusters[i];
        const uint32_t named[] = {cluster->made_by, cluster->used_by};
        for (int k = 0; k < 2; ++k) {
            if (named[k] != STP_STORE_NONE && named[k] >= d->level_group_count) {
                return stp_fail(validator->context, validator->failure,
                                "%s: level cluster %u: group %u does not exist (there are %u)",
                                validator->path, i, named[k], d->level_group_count);
            }
        }
        if (named[0] != STP_STORE_NONE && named[1] != STP_STORE_NONE &&
            !(d->level_groups[named[0]].error < d->level_groups[named[1]].error)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: level cluster %u: the error does not grow from group %u, which "
                            "made it, to group %u, which uses it",
                            validator->path, i, named[0], named[1]);
        }
        if (cluster->one_sided > STP_CLUSTER_TRIANGLES) {
            return stp_fail(validator->context, validator->failure,
                            "%s: level cluster %u: %u one-sided triangles are more than %d",
                            validator->path, i, cluster->one_sided, STP_CLUSTER_TRIANGLES);
        }
    }
    return STP_OK;
}

static stp_result check_level(const stp_store_validator* validator, const stp_store_directory* d,
                              uint32_t index, const stp_store_level* level)
{
    if (level->node >= d->node_count) {
        return stp_fail(validator->context, validator->failure,
                        "%s: level %u: node %u does not exist (there are %u)", validator->path,
                        index, level->node, d->node_count);
    }
    if (level->flags > STP_LEVEL_FROM_OUTSIDE) {
        return stp_fail(validator->context, validator->failure,
                        "%s: level %u: flags %#x are not defined in this version", validator->path,
                        index, level->flags);
    }
    if (index > 0 && level->node < d->levels[index - 1].node) {
        return stp_fail(validator->context, validator->failure,
                        "%s: level %u: node %u comes after node %u", validator->path, index,
                        level->node, d->levels[index - 1].node);
    }
    if (level->cluster_count == STP_STORE_NONE) {
        return stp_fail(validator->context, validator->failure,
                        "%s: level %u: mesh %u is not stored as clusters", validator->path, index,
                        level->mesh);
    }
    return STP_OK;
}

static stp_result check_parts(const stp_store_validator* validator, const stp_store_directory* d)
{
    for (uint32_t i = 0; i < d->part_count; ++i) {
        stp_store_part part = d->parts[i];
        if (part.kind == STP_STORE_PART_MESH && part.index >= stp_store_first_level_mesh(d)) {
            return stp_fail(validator->context, validator->failure,
                            "%s: part %u: mesh %u is a level, which belongs to no node",
                            validator->path, i, part.index);
        }
    }
    return STP_OK;
}

// The range of allowed errors in which a level draws something. Groups must be checked.
static void find_range(const stp_store_directory* d, stp_store_level* level)
{
    level->least = FLT_MAX;
    level->most = 0.0f;
    for (uint32_t i = 0; i < level->cluster_count; ++i) {
        const stp_store_level_cluster* c = &d->level_clusters[level->first_cluster + i];
        float made = c->made_by != STP_STORE_NONE ? d->level_groups[c->made_by].error : 0.0f;
        float used = c->used_by != STP_STORE_NONE ? d->level_groups[c->used_by].error : FLT_MAX;
        level->least = stp_min(level->least, made);
        level->most = stp_max(level->most, used);
    }
}

// Checks all levels and fills their fields. `levels` are the directory's, whose cluster_count is
// that of their mesh, or STP_STORE_NONE for a mesh that is not coded.
static stp_result link_levels(const stp_store_validator* validator, const stp_store_directory* d,
                              stp_store_level* levels)
{
    if (d->level_count > d->mesh_count) {
        return stp_fail(validator->context, validator->failure,
                        "%s: has %u levels, but only %u meshes", validator->path, d->level_count,
                        d->mesh_count);
    }
    stp_result result = check_groups(validator, d);
    result = result == STP_OK ? check_clusters(validator, d) : result;
    result = result == STP_OK ? check_parts(validator, d) : result;
    uint64_t clusters = 0;
    for (uint32_t i = 0; i < d->level_count && result == STP_OK; ++i) {
        levels[i].mesh = stp_store_first_level_mesh(d) + i;
        levels[i].first_cluster = (uint32_t)clusters;
        result = check_level(validator, d, i, &levels[i]);
        clusters += result == STP_OK ? levels[i].cluster_count : 0;
        if (result == STP_OK && clusters <= d->level_cluster_count) {
            find_range(d, &levels[i]);
        }
    }
    if (result == STP_OK && clusters != d->level_cluster_count) {
        result = stp_fail(validator->context, validator->failure,
                          "%s: has %u level clusters, but its levels have %llu", validator->path,
                          d->level_cluster_count, (unsigned long long)clusters);
    }
    return result;
}

const char* stp_store_level_fault(const stp_store_level_cluster* levels,
                                  const stp_clusters* clusters)
{
    for (uint32_t i = 0; i < clusters->cluster_count; ++i) {
        if (levels[i].one_sided > stp_clusters_triangles(clusters, i)) {
            return "has a cluster with more one-sided triangles than triangles";
        }
    }
    return NULL;
}

// The levels of each node. @return NULL if memory runs out
static uint32_t* find_starts(stp_context* context, const stp_store_directory* d)
{
    uint32_t* starts = STP_NEW_ZEROED(context, uint32_t, (size_t)d->node_count + 1);
    for (uint32_t i = 0; starts != NULL && i < d->level_count; ++i) {
        starts[d->levels[i].node + 1] = i + 1;
    }
    for (uint32_t i = 0; starts != NULL && i < d->node_count; ++i) {
        starts[i + 1] = starts[i + 1] > starts[i] ? starts[i + 1] : starts[i];
    }
    assert(starts == NULL || starts[d->node_count] == d->level_count);
    return starts;
}

stp_result stp_store_validate_level_figures(const stp_store* store)
{
    uint32_t count = store->counts[STP_SECTION_LEVEL_FIGURES];
    const stp_store_section* levels = store->known[STP_SECTION_LEVELS];
    const stp_store_level_figures* figures = store->tables[STP_SECTION_LEVEL_FIGURES];
    if (count > 1 || (count == 1 && (levels == NULL || figures->levels != levels->count))) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: %u records of figures of levels for %llu levels", store->path, count,
                        levels != NULL ? (unsigned long long)levels->count : 0);
    }
    return STP_OK;
}

/// Whether the stored figures are those of the levels.
static stp_result check_figures(const stp_store* store)
{
    const stp_store_directory* d = &store->directory;
    const stp_store_level_figures* figures = store->tables[STP_SECTION_LEVEL_FIGURES];
    const stp_store_mesh_record* meshes = store->tables[STP_SECTION_MESHES];
    uint64_t triangles = 0, bytes = 0;
    for (uint32_t i = 0; i < d->level_count; ++i) {
        const stp_store_mesh_record* mesh = &meshes[d->levels[i].mesh];
        triangles += mesh->mesh.triangle_count;
        bytes += stp_store_block_at(store, mesh->block)->size;
    }
    if (figures != NULL && (figures->triangles != triangles || figures->bytes != bytes)) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: figures of levels: %llu triangles in %llu bytes, but levels have %llu "
                        "in %llu",
                        store->path, (unsigned long long)figures->triangles,
                        (unsigned long long)figures->bytes, (unsigned long long)triangles,
                        (unsigned long long)bytes);
    }
    return STP_OK;
}

stp_result stp_store_link_levels(stp_store* store)
{
    const stp_store_directory* d = &store->directory;
    stp_store_level* levels = store->tables[STP_SECTION_LEVELS];
    const stp_store_clusters_record* records = store->tables[STP_SECTION_CLUSTERS];
    for (uint32_t i = 0; i < d->level_count && d->level_count <= d->mesh_count; ++i) {
        uint32_t mesh = stp_store_first_level_mesh(d) + i;
        levels[i].cluster_count = records != NULL ? records[mesh].cluster_count : STP_STORE_NONE;
    }
    stp_store_validator validator = stp_store_own_validator(store);
    stp_result result = link_levels(&validator, d, levels);
    result = result == STP_OK ? stp_store_validate_level_figures(store) : result;
    result = result == STP_OK ? check_figures(store) : result;
    if (result == STP_OK && d->level_count != 0) {
        store->level_starts = find_starts(store->context, d);
        store->directory.level_starts = store->level_starts;
        result = store->level_starts != NULL ? STP_OK : stp_fail_memory(store->context);
    }
    return result;
}

// The writer's coded meshes, whose clusters are not opened.
static stp_result check_coded(const stp_store_validator* validator,
                              const stp_store_content* content, const stp_store_level* levels)
{
    const stp_store_directory* d = &content->directory;
    for (uint32_t i = 0; i < d->level_count; ++i) {
        const stp_coded_mesh* coded = &content->coded_meshes[levels[i].mesh];
        stp_clusters clusters = {.bytes = coded->bytes,
                                 .size = coded->size,
                                 .cluster_count = coded->cluster_count,
                                 .triangle_count = coded->triangle_count};
        bool whole = coded->size >=
                     CLUSTERS_HEADER_BYTES + CLUSTERS_ENTRY_BYTES * (uint64_t)coded->cluster_count;
        const char* fault = "has too few bytes";
        if (whole) {
            fault = stp_store_level_fault(d->level_clusters + levels[i].first_cluster, &clusters);
        }
        if (fault != NULL) {
            return stp_fail(validator->context, validator->failure, "%s: mesh %u %s",
                            validator->path, levels[i].mesh, fault);
        }
    }
    return STP_OK;
}

stp_result stp_store_validate_levels(const stp_store_validator* validator,
                                     const stp_store_content* content)
{
    const stp_store_directory* d = &content->directory;
    if (d->level_count == 0 && d->level_cluster_count == 0 && d->level_group_count == 0) {
        return STP_OK;
    }
    stp_store_level* levels =
        STP_NEW_ARRAY(validator->context, stp_store_level, (size_t)d->level_count + 1);
    if (levels == NULL) {
        return stp_fail_memory(validator->context);
    }
    for (uint32_t i = 0; i < d->level_count; ++i) {
        levels[i] = d->levels[i];
        const stp_coded_mesh* coded =
            d->level_count <= d->mesh_count
                ? stp_store_coded_mesh(content, stp_store_first_level_mesh(d) + i)
                : NULL;
        levels[i].cluster_count = coded != NULL ? coded->cluster_count : STP_STORE_NONE;
    }
    stp_result result = link_levels(validator, d, levels);
    result = result == STP_OK ? check_coded(validator, content, levels) : result;
    stp_free(validator->context, levels);
    return result;
}
