// SPDX-License-Identifier: MIT
// Meshes and point sets (textures: texture_images.c). Data is checked on first use, then read in
// place.
#include "store/file/internal.h"

#include <assert.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "columns are used straight from the file, which is little-endian"
#endif

stp_result stp_store_fail_block(const stp_store* store, const stp_store_block* block,
                                const char* what)
{
    if (!stp_store_is_block_here(store, block)) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends before the block at %llu does", store->path,
                        (unsigned long long)block->offset);
    }
    return stp_fail(store->context, STP_ERROR_FORMAT, "%s: the %s of the block at %llu is wrong",
                    store->path, what, (unsigned long long)block->offset);
}

stp_result stp_store_verify_block(const stp_store* store, const stp_store_block* block,
                                  const unsigned char** bytes)
{
    bool here = stp_store_is_block_here(store, block);
    *bytes = store->file.bytes + (here ? block->offset : 0);
    if (!here || stp_store_crc(0, *bytes, (size_t)block->size) != block->crc) {
        return stp_store_fail_block(store, block, "checksum");
    }
    return STP_OK;
}

stp_result stp_store_fail_index(const stp_store* store, const char* what, uint32_t index)
{
    return stp_fail(store->context, STP_ERROR_ARGUMENT, "%s: %s %u does not exist", store->path,
                    what, index);
}

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

bool stp_store_is_clustered(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_MESHES]);
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    return stp_store_block_at(store, records[index].block)->kind == STP_BLOCK_CLUSTERS;
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

// Replacement colours for the file's own, in separate memory.
static stp_result color_points(stp_store* store, uint32_t index, stp_store_point_record* record,
                               stp_store_point_set* made)
{
    stp_store_block_source source = {.read = stp_store_read_mapped, .user = store};
    uint64_t read_bytes = 0;
    record->colored = stp_alloc_array(store->context, (size_t)made->point_count + 1, 4);
    if (record->colored == NULL) {
        return stp_fail_memory(store->context);
    }
    const char* fault =
        stp_store_color_points(store, index, made->colors, &source, record->colored, &read_bytes);
    if (fault != NULL) {
        stp_free(store->context, record->colored);
        record->colored = NULL;
        stp_store_values values = stp_store_values_of(store, STP_BLOCK_POINT_ATTRIBUTES, index, 0);
        return stp_store_fail_block(store, values.block, fault);
    }
    made->colors = record->colored;
    return STP_OK;
}

stp_result stp_store_get_point_set(stp_store* store, uint32_t index, stp_store_point_set* points)
{
    if (index >= store->directory.point_set_count) {
        return stp_store_fail_index(store, "point set", index);
    }
    stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    stp_store_point_record* record = &records[index];
    if (!record->checked && record->points.held_by != 0) {
        stp_result result = stp_store_make_held_points(store, index, record);
        if (result != STP_OK) {
            return result;
        }
    }
    if (!record->checked) {
        const unsigned char* bytes = NULL;
        stp_result result =
            stp_store_verify_block(store, stp_store_block_at(store, record->block), &bytes);
        if (result != STP_OK) {
            return result;
        }
        stp_store_point_set made = record->points;
        stp_store_find_point_columns(record->present, bytes, &made);
        stp_store_validator validator = stp_store_own_validator(store);
        result = stp_store_validate_point_data(&validator, index, &made);
        if (result == STP_OK && stp_store_is_colored(store)) {
            result = color_points(store, index, record, &made);
        }
        if (result != STP_OK) {
            return result;
        }
        record->points = made;
        record->checked = true;
    }
    *points = record->points;
    return STP_OK;
}

const stp_store_mesh* stp_store_describe_mesh(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_MESHES]);
    const stp_store_mesh_record* records = store->tables[STP_SECTION_MESHES];
    return &records[index].mesh;
}

const stp_store_point_set* stp_store_describe_point_set(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_POINT_SETS]);
    const stp_store_point_record* records = store->tables[STP_SECTION_POINT_SETS];
    return &records[index].points;
}

const stp_splats* stp_store_describe_splat_set(const stp_store* store, uint32_t index)
{
    assert(index < store->counts[STP_SECTION_SPLAT_SETS]);
    const stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    return &records[index].splats;
}
