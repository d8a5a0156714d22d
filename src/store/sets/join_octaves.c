// SPDX-License-Identifier: MIT
// Surfels: joins the columns of the requested octaves from their blocks.
#include "store/bytes/chunks.h"
#include "store/file/internal.h"

#include <assert.h>
#include <string.h>

// Header of a set's memory. Shorter columns that callers may still use are chained behind it.
struct stp_store_joined {
    struct stp_store_joined* older;
};

void stp_store_cut_surfels(stp_splats* surfels, uint32_t octave_count)
{
    if (octave_count >= surfels->octave_count) {
        return;
    }
    surfels->octave_count = octave_count;
    surfels->count = octave_count == 0 ? 0 : surfels->octave_ends[octave_count - 1];
    stp_prefix_table* table = &surfels->table;
    while (table->size > 0 && table->count[table->size - 1] > surfels->count) {
        table->size -= 1;
    }
    if (surfels->paper_count > surfels->count) { // the estimate needs its whole prefix
        surfels->paper_count = 0;
        surfels->paper_radius = 0.0f;
    }
}

uint32_t stp_store_octaves_for(const stp_splats* surfels, uint32_t count)
{
    uint32_t octaves = 0;
    while (octaves < surfels->octave_count && stp_store_octave_begin(surfels, octaves) < count) {
        octaves += 1;
    }
    return octaves;
}

void stp_store_free_columns(stp_context* context, stp_store_surfels_record* record)
{
    while (record->joined != NULL) {
        stp_store_joined* older = record->joined->older;
        stp_free(context, record->joined);
        record->joined = older;
    }
    record->ready = 0;
    record->surfels.positions = NULL;
    record->surfels.normals = NULL;
    record->surfels.materials = NULL;
    record->surfels.colors = NULL;
    record->surfels.coverages = NULL;
    record->surfels.shapes = record->surfels.ranges = NULL;
    record->surfels.groups = NULL;
}

void stp_store_set_columns(stp_store_surfels_record* record, stp_store_joined* joined,
                           const stp_splats* columns, uint32_t octave_count)
{
    assert(octave_count <= record->whole);
    record->joined = joined;
    record->ready = octave_count;
    record->surfels.positions = columns->positions;
    record->surfels.normals = columns->normals;
    record->surfels.materials = columns->materials;
    record->surfels.colors = columns->colors;
    record->surfels.coverages = columns->coverages;
    record->surfels.shapes = columns->shapes;
    record->surfels.ranges = columns->ranges;
    record->surfels.groups = columns->groups;
}

void stp_store_release_surfels(stp_store* store, uint32_t index)
{
    stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    if (index < store->directory.surfels_count && store->residency == NULL) {
        stp_store_free_columns(store->context, &records[index]);
    }
}

// A set's memory: its columns, and data derived from them.
enum { JOINED_GROUPS = STP_SURFEL_COLUMNS, JOINED_COLUMNS };

// Bytes of each column for this many octaves.
static void measure_columns(const stp_splats* surfels, uint32_t octave_count,
                            uint64_t sizes[JOINED_COLUMNS])
{
    assert(octave_count <= surfels->octave_count);
    uint64_t n = stp_store_octave_begin(surfels, octave_count);
    uint64_t entries = stp_store_pyramid_begin(surfels, octave_count);
    sizes[STP_SURFEL_POSITIONS] = 6 * n;
    sizes[STP_SURFEL_NORMALS] = 2 * n;
    sizes[STP_SURFEL_MATERIALS] = n;
    sizes[STP_SURFEL_COLORS] = 3 * entries;
    sizes[STP_SURFEL_COVERAGES] = entries;
    sizes[STP_SURFEL_SHAPES] = (surfels->columns & STP_SPLATS_SHAPES) != 0 ? 4 * n : 0;
    bool ranges = (surfels->columns & STP_SPLATS_RANGES) != 0;
    sizes[STP_SURFEL_RANGES] = ranges ? 4 * n : 0;
    sizes[JOINED_GROUPS] = ranges ? stp_store_group_count(n) * sizeof(stp_splat_group) : 0;
}

// Lays out the columns of `octave_count` octaves in a set's memory, 64-byte aligned. @return the
// end
static uint64_t place_columns(const stp_splats* surfels, uint32_t octave_count,
                              uint64_t offsets[JOINED_COLUMNS])
{
    uint64_t sizes[JOINED_COLUMNS], end = STP_STORE_ALIGNMENT;
    measure_columns(surfels, octave_count, sizes);
    for (int i = 0; i < JOINED_COLUMNS; ++i) {
        offsets[i] = end;
        end = stp_store_align(end + sizes[i], STP_STORE_ALIGNMENT);
    }
    return end;
}

uint64_t stp_store_columns_bytes(const stp_splats* surfels, uint32_t octave_count)
{
    uint64_t offsets[JOINED_COLUMNS];
    return place_columns(surfels, octave_count, offsets);
}

stp_store_joined* stp_store_reserve_columns(stp_context* context, stp_splats* surfels)
{
    uint64_t offsets[JOINED_COLUMNS];
    uint64_t end = place_columns(surfels, surfels->octave_count, offsets);
    unsigned char* memory = stp_alloc(context, (size_t)end);
    if (memory == NULL) {
        return NULL;
    }
    memset(memory, 0, sizeof(stp_store_joined));
    surfels->positions = (uint16_t*)(void*)(memory + offsets[STP_SURFEL_POSITIONS]);
    surfels->normals = (int8_t*)(memory + offsets[STP_SURFEL_NORMALS]);
    surfels->materials = memory + offsets[STP_SURFEL_MATERIALS];
    surfels->colors = memory + offsets[STP_SURFEL_COLORS];
    surfels->coverages = memory + offsets[STP_SURFEL_COVERAGES];
    bool shapes = (surfels->columns & STP_SPLATS_SHAPES) != 0;
    bool ranges = (surfels->columns & STP_SPLATS_RANGES) != 0;
    surfels->shapes = shapes ? (uint32_t*)(void*)(memory + offsets[STP_SURFEL_SHAPES]) : NULL;
    surfels->ranges = ranges ? (uint32_t*)(void*)(memory + offsets[STP_SURFEL_RANGES]) : NULL;
    surfels->groups = ranges ? (stp_splat_group*)(void*)(memory + offsets[JOINED_GROUPS]) : NULL;
    return (stp_store_joined*)(void*)memory;
}

void stp_store_copy_columns(const stp_splats* surfels, const stp_splats* before,
                            uint32_t octave_count)
{
    assert(octave_count <= before->octave_count && octave_count <= surfels->octave_count);
    uint64_t sizes[JOINED_COLUMNS];
    measure_columns(before, octave_count, sizes);
    memcpy(surfels->positions, before->positions, (size_t)sizes[STP_SURFEL_POSITIONS]);
    memcpy(surfels->normals, before->normals, (size_t)sizes[STP_SURFEL_NORMALS]);
    memcpy(surfels->materials, before->materials, (size_t)sizes[STP_SURFEL_MATERIALS]);
    memcpy(surfels->colors, before->colors, (size_t)sizes[STP_SURFEL_COLORS]);
    memcpy(surfels->coverages, before->coverages, (size_t)sizes[STP_SURFEL_COVERAGES]);
    if (surfels->shapes != NULL) {
        memcpy(surfels->shapes, before->shapes, (size_t)sizes[STP_SURFEL_SHAPES]);
    }
    if (surfels->ranges != NULL) {
        memcpy(surfels->ranges, before->ranges, (size_t)sizes[STP_SURFEL_RANGES]);
        memcpy(surfels->groups, before->groups, (size_t)sizes[JOINED_GROUPS]);
    }
}

void stp_store_octave_targets(const stp_splats* surfels, uint32_t octave,
                              void* targets[STP_SURFEL_COLUMNS])
{
    assert(octave < surfels->octave_count);
    size_t first = stp_store_octave_begin(surfels, octave);
    size_t entry = (size_t)stp_store_pyramid_begin(surfels, octave);
    targets[STP_SURFEL_POSITIONS] = surfels->positions + 3 * first;
    targets[STP_SURFEL_NORMALS] = surfels->normals + 2 * first;
    targets[STP_SURFEL_MATERIALS] = surfels->materials + first;
    targets[STP_SURFEL_COLORS] = surfels->colors + 3 * entry;
    targets[STP_SURFEL_COVERAGES] = surfels->coverages + entry;
    targets[STP_SURFEL_SHAPES] = surfels->shapes != NULL ? surfels->shapes + first : NULL;
    targets[STP_SURFEL_RANGES] = surfels->ranges != NULL ? surfels->ranges + first : NULL;
}

bool stp_store_read_mapped(void* user, uint64_t offset, void* bytes, size_t size)
{
    const stp_store* store = user;
    bool whole = offset <= store->file.size && size <= store->file.size - offset;
    if (whole) {
        memcpy(bytes, store->file.bytes + offset, size);
    }
    return whole;
}

const stp_store_block* stp_store_octave_block(const stp_store* store, uint32_t index,
                                              uint32_t octave)
{
    const stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
    assert(octave < records[index].surfels.octave_count);
    return stp_store_block_at(store, octaves[records[index].first_octave + octave].block);
}

bool stp_store_has_operators(const stp_store* store, uint32_t index, uint32_t octave_count)
{
    const stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    bool found = false;
    for (uint32_t k = 0; k < octave_count && k < records[index].surfels.octave_count; ++k) {
        found = found ||
                stp_store_octave_block(store, index, k)->encoding == STP_STORE_ENCODING_OPERATORS;
    }
    return found;
}

stp_result stp_store_add_octave(stp_store* store, uint32_t index, uint32_t octave,
                                const stp_splats* surfels)
{
    const stp_store_block* block = stp_store_octave_block(store, index, octave);
    stp_store_octave_span span = stp_store_span_of(surfels, octave, block->encoding);
    stp_store_block_source source = {
        .block = block, .read = stp_store_read_mapped, .user = store, .set = surfels};
    if (block->encoding == STP_STORE_ENCODING_OPERATORS) {
        source.waiting = stp_alloc(store->context, (size_t)stp_store_waiting_bytes(span.end));
        if (source.waiting == NULL) {
            return stp_fail_memory(store->context);
        }
    }
    void* targets[STP_SURFEL_COLUMNS];
    uint64_t read_bytes = 0;
    stp_store_octave_targets(surfels, octave, targets);
    const char* fault = stp_store_read_chunks(&source, &span, 0, stp_store_chunk_count(&span),
                                              targets, &read_bytes);
    if (fault == NULL) {
        fault = stp_store_color_octave(store, index, octave, surfels, &source, &read_bytes);
    }
    stp_free(store->context, source.waiting);
    if (fault != NULL) {
        return stp_store_fail_block(store, block, fault);
    }
    stp_store_validator validator = stp_store_own_validator(store);
    stp_store_surfel_data data = {span.end - span.first, targets[STP_SURFEL_MATERIALS],
                                  targets[STP_SURFEL_SHAPES], targets[STP_SURFEL_RANGES]};
    stp_store_make_groups(surfels, span.first, span.end);
    return stp_store_validate_surfel_data(&validator, index, &data, store->directory.shading_count);
}

// Joins the first `octave_count` octaves, more than are ready, in new memory.
static stp_result join_octaves(stp_store* store, uint32_t index, uint32_t octave_count)
{
    stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    stp_store_surfels_record* record = &records[index];
    assert(octave_count > record->ready && octave_count <= record->whole);
    stp_splats made = record->surfels;
    stp_store_cut_surfels(&made, octave_count);
    stp_store_joined* joined = stp_store_reserve_columns(store->context, &made);
    if (joined == NULL) {
        return stp_fail_memory(store->context);
    }
    if (record->ready != 0) {
        stp_store_copy_columns(&made, &record->surfels, record->ready);
    }
    for (uint32_t octave = record->ready; octave < octave_count; ++octave) {
        stp_result result = stp_store_add_octave(store, index, octave, &made);
        if (result != STP_OK) {
            stp_free(store->context, joined);
            return result;
        }
    }
    joined->older = record->joined;
    stp_store_set_columns(record, joined, &made, octave_count);
    return STP_OK;
}

stp_result stp_store_get_surfels_prefix(stp_store* store, uint32_t index, uint32_t octave_count,
                                        stp_splats* surfels)
{
    if (index >= store->directory.surfels_count) {
        return stp_store_fail_index(store, "surfel set", index);
    }
    const stp_store_surfels_record* records = store->tables[STP_SECTION_SURFELS];
    const stp_store_surfels_record* record = &records[index];
    if (octave_count > record->whole) {
        octave_count = record->whole;
    }
    if (store->residency != NULL && octave_count > record->ready) {
        octave_count = record->ready; // never waits for data that is not loaded
    }
    if (octave_count > record->ready) {
        stp_result result = join_octaves(store, index, octave_count);
        if (result != STP_OK) {
            return result;
        }
    }
    *surfels = record->surfels;
    stp_store_cut_surfels(surfels, octave_count);
    assert(surfels->octave_count <= record->ready && "only octaves in memory");
    return STP_OK;
}

stp_result stp_store_get_surfels(stp_store* store, uint32_t index, stp_splats* surfels)
{
    return stp_store_get_surfels_prefix(store, index, STP_OCTAVE_LIMIT, surfels);
}
