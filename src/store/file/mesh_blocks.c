// SPDX-License-Identifier: MIT
// Meshes, and the columns of meshes and point sets in their blocks. Data is checked on first use,
// then read in place.
#include "store/bytes/columns.h"
#include "store/file/block_table.h"

#include <assert.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "columns are used straight from the file, which is little-endian"
#endif

// The first byte of a column; NULL if the file lacks it.
static const void* column_at(const unsigned char* bytes, const stp_store_column* column,
                             bool present)
{
    return present ? bytes + column->offset : NULL;
}

void stp_store_find_mesh_columns(uint32_t present, const unsigned char* bytes, stp_store_mesh* mesh)
{
    assert((uintptr_t)bytes % STP_STORE_COLUMN_ALIGNMENT == 0);
    stp_store_column c[STP_STORE_COLUMN_LIMIT];
    stp_store_mesh_columns(mesh->vertex_count, mesh->triangle_count, present, c);
    mesh->positions = column_at(bytes, &c[STP_MESH_POSITIONS], true);
    mesh->normals = column_at(bytes, &c[STP_MESH_NORMALS], (present & STP_COLUMN_NORMALS) != 0);
    mesh->texcoords[0] =
        column_at(bytes, &c[STP_MESH_TEXCOORDS_0], (present & STP_COLUMN_TEXCOORDS_0) != 0);
    mesh->texcoords[1] =
        column_at(bytes, &c[STP_MESH_TEXCOORDS_1], (present & STP_COLUMN_TEXCOORDS_1) != 0);
    mesh->colors = column_at(bytes, &c[STP_MESH_COLORS], (present & STP_COLUMN_COLORS) != 0);
    mesh->indices = column_at(bytes, &c[STP_MESH_INDICES], true);
}

void stp_store_find_point_columns(uint32_t present, const unsigned char* bytes,
                                  stp_store_point_set* points)
{
    assert((uintptr_t)bytes % STP_STORE_COLUMN_ALIGNMENT == 0);
    stp_store_column c[STP_STORE_COLUMN_LIMIT];
    stp_store_point_columns(points->point_count, present, c);
    points->positions = column_at(bytes, &c[STP_POINT_POSITIONS], true);
    points->normals = column_at(bytes, &c[STP_POINT_NORMALS], (present & STP_COLUMN_NORMALS) != 0);
    points->colors = column_at(bytes, &c[STP_POINT_COLORS], (present & STP_COLUMN_COLORS) != 0);
}

stp_result stp_store_get_mesh(stp_store* store, uint32_t index, stp_store_mesh* mesh)
{
    if (index >= store->directory.mesh_count) {
        return stp_store_fail_index(store, "mesh", index);
    }
    stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    stp_store_mesh_record* record = &records[index];
    if (stp_store_is_clustered(store, index)) {
        return stp_fail(store->context, STP_ERROR_ARGUMENT,
                        "%s: mesh %u is stored as clusters, not as columns", store->path, index);
    }
    if (!record->checked) {
        const unsigned char* bytes = NULL;
        stp_result result =
            stp_store_verify_block(store, stp_store_block_at(store, record->block), &bytes);
        if (result != STP_OK) {
            return result;
        }
        stp_store_mesh made = record->mesh;
        stp_store_find_mesh_columns(record->present, bytes, &made);
        stp_store_validator validator = stp_store_own_validator(store);
        result = stp_store_validate_mesh_data(&validator, index, &made);
        if (result != STP_OK) {
            return result;
        }
        record->mesh = made;
        record->checked = true;
    }
    *mesh = record->mesh;
    return STP_OK;
}

const char* stp_store_find_clusters(const stp_store* store, uint32_t index,
                                    const unsigned char* bytes, stp_clusters* clusters)
{
    assert(stp_store_is_clustered(store, index));
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    const stp_store_clusters_record* known = store->tables[STP_SECTION_CLUSTERS];
    const stp_store_mesh_record* record = &records[index];
    size_t size = (size_t)stp_store_block_at(store, record->block)->size;
    const char* fault = stp_clusters_open(bytes, size, clusters);
    if (fault == NULL && (clusters->cluster_count != known[index].cluster_count ||
                          clusters->triangle_count != record->mesh.triangle_count ||
                          clusters->vertex_count != record->mesh.vertex_count ||
                          clusters->present != record->present)) {
        fault = "has clusters whose counts or columns differ from its record";
    }
    uint32_t first_level = stp_store_first_level_mesh(&store->directory);
    if (fault == NULL && index >= first_level) {
        const stp_store_level* level = &store->directory.levels[index - first_level];
        assert(level->cluster_count == clusters->cluster_count);
        fault =
            stp_store_level_fault(store->directory.level_clusters + level->first_cluster, clusters);
    }
    return fault;
}

static stp_result open_clusters(stp_store* store, uint32_t index,
                                stp_store_clusters_record* clusters)
{
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    const stp_store_block* block = stp_store_block_at(store, records[index].block);
    const unsigned char* bytes = NULL;
    stp_result result = stp_store_verify_block(store, block, &bytes);
    if (result != STP_OK) {
        return result;
    }
    stp_clusters made;
    const char* fault = stp_store_find_clusters(store, index, bytes, &made);
    if (fault != NULL) {
        return stp_fail(store->context, STP_ERROR_FORMAT, "%s: mesh %u %s", store->path, index,
                        fault);
    }
    clusters->clusters = made;
    return STP_OK;
}

stp_result stp_store_get_clusters(stp_store* store, uint32_t index, stp_clusters* clusters)
{
    if (index >= store->directory.mesh_count) {
        return stp_store_fail_index(store, "mesh", index);
    }
    if (!stp_store_is_clustered(store, index)) {
        return stp_fail(store->context, STP_ERROR_ARGUMENT,
                        "%s: mesh %u is stored as columns, not as clusters", store->path, index);
    }
    stp_store_clusters_record* records = store->tables[STP_SECTION_CLUSTERS];
    if (records[index].clusters.bytes == NULL) {
        stp_result result = open_clusters(store, index, &records[index]);
        if (result != STP_OK) {
            return result;
        }
    }
    *clusters = records[index].clusters;
    return STP_OK;
}
