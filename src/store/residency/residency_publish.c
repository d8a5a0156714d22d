// SPDX-License-Identifier: MIT
// Publishes loads and drops in the store's tables. Between frames only, on the updating thread.
#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/residency/residency_internal.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

static stp_store_set_record* set_record(const stp_residency* r, uint32_t resource)
{
    assert(stp_residency_kind(r, resource) == STP_RESIDENT_SPLATS);
    stp_store_set_record* records = r->store->tables[STP_SECTION_SPLAT_SETS];
    return &records[resource - r->firsts[STP_RESIDENT_SPLATS]];
}

/// Memory for the texels and, for a picture, its file and decoder.
static bool prepare_texture(stp_residency* r, stp_load* load)
{
    const stp_store_texture* texture = stp_residency_texture(r, load->resource);
    load->memory = stp_alloc_array(r->context, (size_t)texture->width * texture->height, 4);
    if (load->memory == NULL || texture->encoding == 0) {
        return load->memory != NULL;
    }
    uint64_t size = stp_residency_block(r, load->resource, 0)->size;
    load->decoder = stp_residency_decoder_bytes(r, load->resource);
    if (stp_reserve(r->context, load->decoder)) {
        load->picture = stp_alloc(r->context, size > 0 ? (size_t)size : 1);
        if (load->picture != NULL) {
            return true;
        }
        stp_release(r->context, load->decoder);
    }
    stp_free(r->context, load->memory);
    load->memory = NULL;
    return false;
}

/// Memory for the columns and, for operators, the queue of parents.
static bool prepare_splats(stp_residency* r, stp_load* load)
{
    const stp_splats* splats = &set_record(r, load->resource)->splats;
    load->before = *splats;
    load->columns = *splats;
    stp_store_truncate_splat_set(&load->columns, load->to);
    if (load->transient != 0) {
        load->waiting = stp_alloc(r->context, (size_t)stp_store_waiting_bytes(load->columns.count));
        if (load->waiting == NULL) {
            return false;
        }
    }
    load->memory = stp_store_reserve_columns(r->context, &load->columns);
    if (load->memory == NULL) {
        stp_free(r->context, load->waiting);
        load->waiting = NULL;
    }
    return load->memory != NULL;
}

bool stp_residency_prepare(stp_residency* r, stp_load* load)
{
    if (stp_residency_kind(r, load->resource) == STP_RESIDENT_SPLATS) {
        return prepare_splats(r, load);
    }
    if (stp_residency_kind(r, load->resource) == STP_RESIDENT_TEXTURE) {
        return prepare_texture(r, load);
    }
    uint64_t size = stp_residency_block(r, load->resource, 0)->size +
                    stp_residency_color_bytes(r, load->resource);
    if (stp_residency_kind(r, load->resource) == STP_RESIDENT_LEAVES) {
        uint32_t set = load->resource - r->firsts[STP_RESIDENT_LEAVES];
        size = stp_store_leaves_bytes(stp_store_leaf_count(r->store, set));
    }
    load->memory = stp_alloc(r->context, size > 0 ? (size_t)size : 1);
    return load->memory != NULL;
}

void stp_residency_end_load(stp_residency* r, stp_load* load)
{
    if (load->picture != NULL) {
        stp_free(r->context, load->picture);
        stp_release(r->context, load->decoder);
        load->picture = NULL;
    }
    stp_free(r->context, load->waiting);
    load->waiting = NULL;
}

static void publish_mesh(const stp_residency* r, uint32_t index, void* memory,
                         const stp_clusters* clusters)
{
    stp_store_mesh_record* records = r->store->tables[STP_SECTION_MESHES];
    stp_store_mesh_record* record = &records[index];
    if (stp_store_is_clustered(r->store, index)) {
        stp_store_clusters_record* coded = r->store->tables[STP_SECTION_CLUSTERS];
        coded[index].clusters = memory != NULL ? *clusters : (stp_clusters){0};
        return;
    }
    record->checked = memory != NULL;
    if (memory != NULL) {
        stp_store_find_mesh_columns(record->present, memory, &record->mesh);
    } else {
        record->mesh.positions = NULL;
        record->mesh.normals = NULL;
        record->mesh.texcoords[0] = record->mesh.texcoords[1] = NULL;
        record->mesh.colors = NULL;
        record->mesh.indices = NULL;
    }
}

static void publish_points(const stp_residency* r, uint32_t index, void* memory)
{
    stp_store_point_record* records = r->store->tables[STP_SECTION_POINT_SETS];
    stp_store_point_record* record = &records[index];
    record->checked = memory != NULL;
    if (memory != NULL) {
        stp_store_find_point_columns(record->present, memory, &record->points);
        if (stp_store_is_colored(r->store)) {
            uint64_t size = stp_store_block_at(r->store, record->block)->size;
            record->points.colors = (const uint8_t*)memory + size;
        }
    } else {
        record->points.positions = NULL;
        record->points.normals = NULL;
        record->points.colors = NULL;
    }
}

/// Publishes a resource other than a set. `memory` NULL: the resource is dropped.
static void publish(const stp_residency* r, uint32_t resource, void* memory, const stp_load* load)
{
    stp_resident_kind kind = stp_residency_kind(r, resource);
    uint32_t index = resource - r->firsts[kind];
    if (kind == STP_RESIDENT_MESH) {
        publish_mesh(r, index, memory, load != NULL ? &load->clusters : NULL);
    } else if (kind == STP_RESIDENT_POINTS) {
        publish_points(r, index, memory);
    } else if (kind == STP_RESIDENT_LEAVES) {
        stp_store_publish_leaves(r->store, index, load != NULL ? &load->leaves : NULL);
    } else {
        stp_store_texture_record* records = r->store->tables[STP_SECTION_TEXTURES];
        records[index].texture.texels = memory;
        records[index].checked = memory != NULL;
    }
}

static void free_resource(stp_residency* r, stp_resident* t)
{
    assert(t->bytes <= r->bytes);
    stp_free(r->context, t->memory);
    r->bytes -= t->bytes;
    t->memory = NULL;
    t->bytes = 0;
    t->level = 0;
}

void stp_residency_take(stp_residency* r, stp_load* load)
{
    stp_resident* t = &r->resources[load->resource];
    assert(t->load == load && t->level == load->from && "nothing is dropped while it loads");
    assert(load->from <= load->reached && load->reached <= load->to && load->to <= t->maximum);
    t->load = NULL;
    r->under_way -= load->bytes;
    stp_residency_end_load(r, load);
    load->bytes -= load->transient;
    r->bytes -= load->transient;
    r->stats.read_bytes += load->read_bytes;
    r->stats.loaded += load->reached - load->from;
    if (load->reached < load->to && !atomic_load(&r->ending)) {
        t->maximum = (uint8_t)load->reached;
        r->stats.damaged += 1;
    }
    if (load->reached <= load->from) {
        stp_free(r->context, load->memory);
        r->bytes -= load->bytes;
    } else {
        free_resource(r, t);
        t->memory = load->memory;
        t->bytes = load->bytes;
        t->level = (uint8_t)load->reached;
        t->arrival = ++r->store->arrivals;
        if (stp_residency_kind(r, load->resource) == STP_RESIDENT_SPLATS) {
            stp_store_set_columns(set_record(r, load->resource), load->memory, &load->columns,
                                  load->reached);
        } else {
            publish(r, load->resource, load->memory, load);
        }
    }
    load->next = r->spare;
    r->spare = load;
}

/// Copies the first octaves of a set (at least one) to separate memory.
static bool shorten(stp_residency* r, uint32_t resource, uint32_t level)
{
    stp_resident* t = &r->resources[resource];
    assert(level >= 1 && level < t->level);
    stp_store_set_record* record = set_record(r, resource);
    stp_splats columns = record->splats;
    uint64_t bytes = stp_residency_bytes(r, resource, level);
    stp_store_truncate_splat_set(&columns, level);
    stp_store_joined* memory =
        r->bytes + bytes <= r->limit ? stp_store_reserve_columns(r->context, &columns) : NULL;
    if (memory == NULL) {
        return false;
    }
    stp_residency_count(r, bytes);
    stp_store_copy_columns(&columns, &record->splats, level);
    free_resource(r, t);
    stp_store_set_columns(record, memory, &columns, level);
    t->memory = memory;
    t->bytes = bytes;
    t->level = (uint8_t)level;
    return true;
}

void stp_residency_drop(stp_residency* r, uint32_t resource, uint32_t level)
{
    stp_resident* t = &r->resources[resource];
    assert(level < t->level);
    uint32_t before = t->level;
    if (stp_residency_kind(r, resource) != STP_RESIDENT_SPLATS) {
        publish(r, resource, NULL, NULL);
        free_resource(r, t);
    } else {
        while (level > 0 && !shorten(r, resource, level)) { // no memory for the copy
            level -= 1;
        }
        if (level == 0) {
            stp_splats none = {0};
            free_resource(r, t);
            stp_store_set_columns(set_record(r, resource), NULL, &none, 0);
        }
    }
    r->stats.dropped += before - t->level;
}
