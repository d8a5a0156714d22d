// SPDX-License-Identifier: MIT
// Reader threads: take a load from the queue, fill it, check it, hand it back.
#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/file/texture_images.h"
#include "store/residency/residency_internal.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

/// Read state of a block.
typedef struct block_reader {
    stp_residency* r;
    const stp_store_block* block;
    uint64_t done;
    uint32_t crc;
} block_reader;

static bool read_next(block_reader* at, void* bytes, size_t size)
{
    assert(at->done <= at->block->size && size <= at->block->size - at->done);
    stp_residency* r = at->r;
    if (atomic_load_explicit(&r->ending, memory_order_relaxed)) {
        return false;
    }
    if (!r->desc.read(r->desc.read_user, at->block->offset + at->done, bytes, size)) {
        if (!atomic_load(&r->ending)) {
            stp_warn(r->context, "%s: the block at %llu cannot be read and is left out",
                     r->store->path, (unsigned long long)at->block->offset);
        }
        return false;
    }
    at->crc = stp_store_crc(at->crc, bytes, size);
    at->done += size;
    return true;
}

static bool is_right(const block_reader* at)
{
    if (at->crc == at->block->crc) {
        return true;
    }
    stp_warn(at->r->context, "%s: the checksum of the block at %llu is wrong: it is left out",
             at->r->store->path, (unsigned long long)at->block->offset);
    return false;
}

/// Reads a whole block.
static bool read_block(stp_residency* r, const stp_store_block* block, unsigned char* bytes)
{
    block_reader at = {.r = r, .block = block};
    while (at.done < block->size) {
        uint64_t left = block->size - at.done;
        size_t size = left < STP_RESIDENCY_CHUNK ? (size_t)left : STP_RESIDENCY_CHUNK;
        if (!read_next(&at, bytes + at.done, size)) {
            return false;
        }
    }
    return is_right(&at);
}

/// Read callback of stp_store_read_chunks. Fails once the threads must stop.
static bool read_part(void* user, uint64_t offset, void* bytes, size_t size)
{
    stp_residency* r = user;
    return !atomic_load_explicit(&r->ending, memory_order_relaxed) &&
           r->desc.read(r->desc.read_user, offset, bytes, size);
}

static bool read_octave(stp_residency* r, stp_load* load, uint32_t octave)
{
    assert(octave >= load->from && octave < load->to && "earlier octaves are copied");
    uint32_t index = load->resource - r->firsts[STP_RESIDENT_SPLATS];
    const stp_store_block* block = stp_residency_block(r, load->resource, octave);
    stp_store_octave_span span = stp_store_span_of(&load->columns, octave, block->encoding);
    stp_store_block_source source = {.block = block,
                                     .read = read_part,
                                     .user = r,
                                     .set = &load->columns,
                                     .waiting = load->waiting};
    void* targets[STP_OCTAVE_COLUMNS];
    stp_store_octave_targets(&load->columns, octave, targets);
    const char* fault = stp_store_read_chunks(&source, &span, 0, stp_store_chunk_count(&span),
                                              targets, &load->read_bytes);
    if (fault == NULL) {
        fault = stp_store_color_octave(r->store, index, octave, &load->columns, &source,
                                       &load->read_bytes);
    }
    if (fault != NULL && !atomic_load(&r->ending)) {
        stp_warn(r->context,
                 fault == stp_store_unreadable || fault == stp_store_no_memory
                     ? "%s: the %s of the block at %llu cannot be read and is left out"
                     : "%s: the %s of the block at %llu is wrong: it is left out",
                 r->store->path, fault, (unsigned long long)block->offset);
    }
    stp_store_validator validator = stp_store_own_validator(r->store);
    validator.warns = true;
    stp_store_splat_data data = {span.end - span.first, targets[STP_OCTAVE_MATERIALS],
                                 targets[STP_OCTAVE_SHAPES], targets[STP_OCTAVE_RANGES]};
    if (fault == NULL) {
        stp_store_make_groups(&load->columns, span.first, span.end);
    }
    return fault == NULL &&
           stp_store_validate_splat_data(&validator, index, &data,
                                         r->store->directory.shading_count) == STP_OK;
}

static bool check_mesh(stp_residency* r, stp_load* load)
{
    const stp_store_mesh_record* records = r->store->tables[STP_SECTION_MESHES];
    uint32_t index = load->resource - r->firsts[STP_RESIDENT_MESH];
    stp_store_validator validator = stp_store_own_validator(r->store);
    validator.warns = true;
    if (stp_store_is_clustered(r->store, index)) {
        const char* fault = stp_store_find_clusters(r->store, index, load->memory, &load->clusters);
        if (fault != NULL) {
            stp_warn(r->context, "%s: mesh %u %s", r->store->path, index, fault);
        }
        return fault == NULL;
    }
    stp_store_mesh mesh = {.vertex_count = records[index].mesh.vertex_count,
                           .triangle_count = records[index].mesh.triangle_count};
    stp_store_find_mesh_columns(records[index].present, load->memory, &mesh);
    return stp_store_validate_mesh_data(&validator, index, &mesh) == STP_OK;
}

static bool check_points(stp_residency* r, const stp_load* load)
{
    const stp_store_point_record* records = r->store->tables[STP_SECTION_POINT_SETS];
    uint32_t index = load->resource - r->firsts[STP_RESIDENT_POINTS];
    stp_store_validator validator = stp_store_own_validator(r->store);
    validator.warns = true;
    stp_store_point_set points = {.point_count = records[index].points.point_count};
    stp_store_find_point_columns(records[index].present, load->memory, &points);
    return stp_store_validate_point_data(&validator, index, &points) == STP_OK;
}

static bool open_leaves(stp_residency* r, stp_load* load)
{
    uint32_t set = load->resource - r->firsts[STP_RESIDENT_LEAVES];
    const char* fault = stp_store_open_leaves(r->store, set, load->memory, &load->leaves);
    if (fault != NULL) {
        stp_warn(r->context, "%s: splat set %u: %s", r->store->path, set, fault);
    }
    return fault == NULL;
}

/// Replacement colours follow the block's columns.
static bool color_points(stp_residency* r, stp_load* load)
{
    const stp_store_point_record* records = r->store->tables[STP_SECTION_POINT_SETS];
    uint32_t index = load->resource - r->firsts[STP_RESIDENT_POINTS];
    if (!stp_store_is_colored(r->store)) {
        return true;
    }
    stp_store_block_source source = {.read = read_part, .user = r};
    stp_store_point_set points = {.point_count = records[index].points.point_count};
    stp_store_find_point_columns(records[index].present, load->memory, &points);
    uint8_t* colored = (uint8_t*)load->memory + stp_residency_block(r, load->resource, 0)->size;
    const char* fault =
        stp_store_color_points(r->store, index, points.colors, &source, colored, &load->read_bytes);
    if (fault != NULL && !atomic_load(&r->ending)) {
        stp_warn(r->context, "%s: attributes of point set %u: the %s is wrong: they are left out",
                 r->store->path, index, fault);
    }
    return fault == NULL;
}

static bool decode_picture(const stp_residency* r, const stp_load* load,
                           const stp_store_block* block)
{
    const stp_store_texture* texture = stp_residency_texture(r, load->resource);
    stp_image_info info;
    size_t size = (size_t)block->size;
    stp_result result = stp_store_measure_picture(texture, load->picture, size, &info);
    if (result == STP_OK) {
        result = stp_image_decode_into(load->picture, size, &info, load->memory);
    }
    if (result != STP_OK) {
        stp_warn(r->context, "%s: texture %u: %s: it is left out", r->store->path,
                 load->resource - r->firsts[STP_RESIDENT_TEXTURE],
                 result == STP_ERROR_OUT_OF_MEMORY ? "out of memory" : info.reason);
    }
    return result == STP_OK;
}

static void fill_load(stp_residency* r, stp_load* load)
{
    assert(load->from < load->to && load->memory != NULL);
    load->reached = load->from;
    load->read_bytes = 0;
    stp_resident_kind kind = stp_residency_kind(r, load->resource);
    if (kind == STP_RESIDENT_SPLATS) {
        if (load->from > 0) {
            stp_store_copy_columns(&load->columns, &load->before, load->from);
        }
        while (load->reached < load->to && read_octave(r, load, load->reached)) {
            load->reached += 1;
        }
        return;
    }
    const stp_store_block* block = stp_residency_block(r, load->resource, 0);
    bool good = read_block(r, block, load->picture != NULL ? load->picture : load->memory);
    good = good && (load->picture == NULL || decode_picture(r, load, block));
    good = good && (kind != STP_RESIDENT_MESH || check_mesh(r, load));
    good =
        good && (kind != STP_RESIDENT_POINTS || (check_points(r, load) && color_points(r, load)));
    good = good && (kind != STP_RESIDENT_LEAVES || open_leaves(r, load));
    load->read_bytes = good ? block->size : 0;
    load->reached = good ? 1 : 0;
}

static void* run_reader(void* argument)
{
    stp_residency* r = argument;
    pthread_mutex_lock(&r->mutex);
    while (!atomic_load(&r->ending)) {
        stp_load* load = r->queue;
        if (load == NULL) {
            pthread_cond_wait(&r->work, &r->mutex);
            continue;
        }
        r->queue = load->next;
        pthread_mutex_unlock(&r->mutex);
        fill_load(r, load);
        pthread_mutex_lock(&r->mutex);
        load->next = r->arrived;
        r->arrived = load;
        assert(r->busy > 0);
        r->busy -= 1;
        if (r->busy == 0) {
            pthread_cond_broadcast(&r->done);
        }
    }
    pthread_mutex_unlock(&r->mutex);
    return NULL;
}

stp_result stp_residency_start_threads(stp_residency* r)
{
    assert(r->threads == NULL && r->thread_count == 0 && "started once");
    uint32_t wanted = r->desc.thread_count;
    r->threads = STP_NEW_ARRAY(r->context, pthread_t, wanted);
    if (r->threads == NULL) {
        return stp_fail_memory(r->context);
    }
    while (r->thread_count < wanted) {
        if (pthread_create(&r->threads[r->thread_count], NULL, run_reader, r) != 0) {
            return stp_fail(r->context, STP_ERROR_LIMIT, "%s: cannot start reader threads",
                            r->store->path);
        }
        r->thread_count += 1;
    }
    return STP_OK;
}

void stp_residency_end_threads(stp_residency* r)
{
    pthread_mutex_lock(&r->mutex);
    atomic_store(&r->ending, true);
    pthread_cond_broadcast(&r->work);
    pthread_mutex_unlock(&r->mutex);
    for (uint32_t i = 0; i < r->thread_count; ++i) {
        pthread_join(r->threads[i], NULL);
    }
    r->thread_count = 0;
    stp_free(r->context, r->threads);
    r->threads = NULL;
}

void stp_residency_start(stp_residency* r)
{
    assert((r->first_load == NULL) == (r->last_load == NULL));
    if (r->first_load == NULL) {
        return;
    }
    assert(r->last_load->next == NULL);
    pthread_mutex_lock(&r->mutex);
    if (r->queue == NULL) {
        r->queue = r->first_load;
    } else {
        r->queue_end->next = r->first_load;
    }
    r->queue_end = r->last_load;
    for (const stp_load* load = r->first_load; load != NULL; load = load->next) {
        r->busy += 1;
    }
    pthread_cond_broadcast(&r->work);
    pthread_mutex_unlock(&r->mutex);
    r->first_load = r->last_load = NULL;
}
