// SPDX-License-Identifier: MIT
// Splats: joins the columns of the requested octaves from their blocks.
#include "base/splats/light_normal.h"
#include "store/bytes/chunks.h"
#include "store/file/block_table.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

// Header of a set's memory. Shorter columns that callers may still use are chained behind it.
struct stp_store_joined {
    struct stp_store_joined* older;
};

void stp_store_truncate_splat_set(stp_splats* splats, uint32_t octave_count)
{
    if (octave_count >= splats->octave_count) {
        return;
    }
    splats->octave_count = octave_count;
    splats->light_octaves &= (1u << octave_count) - 1;
    splats->count = octave_count == 0 ? 0 : splats->octave_ends[octave_count - 1];
    stp_prefix_table* table = &splats->table;
    while (table->size > 0 && table->count[table->size - 1] > splats->count) {
        table->size -= 1;
    }
    if (splats->paper_count > splats->count) { // the estimate needs its whole prefix
        splats->paper_count = 0;
        splats->paper_radius = 0.0f;
    }
}

uint32_t stp_store_octaves_for(const stp_splats* splats, uint32_t count)
{
    uint32_t octaves = 0;
    while (octaves < splats->octave_count && stp_store_octave_begin(splats, octaves) < count) {
        octaves += 1;
    }
    return octaves;
}

void stp_store_free_columns(stp_context* context, stp_store_set_record* record)
{
    while (record->joined != NULL) {
        stp_store_joined* older = record->joined->older;
        stp_free(context, record->joined);
        record->joined = older;
    }
    record->ready = 0;
    record->splats.positions = NULL;
    record->splats.normals = NULL;
    record->splats.materials = NULL;
    record->splats.colors = NULL;
    record->splats.coverages = NULL;
    record->splats.turns = NULL;
    record->splats.spreads = NULL;
    record->splats.shapes = record->splats.ranges = record->splats.errors = NULL;
    record->splats.groups = NULL;
}

void stp_store_set_columns(stp_store_set_record* record, stp_store_joined* joined,
                           const stp_splats* columns, uint32_t octave_count)
{
    assert(octave_count <= record->whole);
    record->joined = joined;
    record->ready = octave_count;
    record->splats.positions = columns->positions;
    record->splats.normals = columns->normals;
    record->splats.materials = columns->materials;
    record->splats.colors = columns->colors;
    record->splats.coverages = columns->coverages;
    record->splats.turns = columns->turns;
    record->splats.spreads = columns->spreads;
    record->splats.shapes = columns->shapes;
    record->splats.ranges = columns->ranges;
    record->splats.errors = columns->errors;
    record->splats.groups = columns->groups;
}

void stp_store_release_splat_set(stp_store* store, uint32_t index)
{
    stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    if (index < store->directory.set_count && store->residency == NULL) {
        stp_store_free_columns(store->context, &records[index]);
    }
}

// A set's memory: its columns, and data derived from them.
enum { JOINED_GROUPS = STP_OCTAVE_COLUMNS, JOINED_COLUMNS };

// Bytes of each column for this many octaves.
static void measure_columns(const stp_splats* splats, uint32_t octave_count,
                            uint64_t sizes[JOINED_COLUMNS])
{
    assert(octave_count <= splats->octave_count);
    uint64_t n = stp_store_octave_begin(splats, octave_count);
    uint64_t entries = stp_store_pyramid_begin(splats, octave_count);
    sizes[STP_OCTAVE_POSITIONS] = 6 * n;
    sizes[STP_OCTAVE_NORMALS] = 2 * n;
    sizes[STP_OCTAVE_MATERIALS] = n;
    sizes[STP_OCTAVE_COLORS] = 3 * entries;
    sizes[STP_OCTAVE_COVERAGES] = entries;
    sizes[STP_OCTAVE_SHAPES] = (splats->columns & STP_SPLATS_SHAPES) != 0 ? 4 * n : 0;
    bool ranges = (splats->columns & STP_SPLATS_RANGES) != 0;
    sizes[STP_OCTAVE_RANGES] = ranges ? 4 * n : 0;
    sizes[STP_OCTAVE_ERRORS] = (splats->columns & STP_SPLATS_ERRORS) != 0 ? 4 * n : 0;
    uint64_t lights = stp_light_normals_begin(splats, octave_count);
    sizes[STP_OCTAVE_TURNS] = 2 * lights;
    sizes[STP_OCTAVE_SPREADS] = lights;
    sizes[JOINED_GROUPS] = ranges ? stp_store_group_count(n) * sizeof(stp_splat_group) : 0;
}

// Lays out the columns of `octave_count` octaves in a set's memory, 64-byte aligned. @return the
// end
static uint64_t place_columns(const stp_splats* splats, uint32_t octave_count,
                              uint64_t offsets[JOINED_COLUMNS])
{
    uint64_t sizes[JOINED_COLUMNS], end = STP_STORE_ALIGNMENT;
    measure_columns(splats, octave_count, sizes);
    for (int i = 0; i < JOINED_COLUMNS; ++i) {
        offsets[i] = end;
        end = stp_store_align(end + sizes[i], STP_STORE_ALIGNMENT);
    }
    return end;
}

uint64_t stp_store_columns_bytes(const stp_splats* splats, uint32_t octave_count)
{
    uint64_t offsets[JOINED_COLUMNS];
    return place_columns(splats, octave_count, offsets);
}

stp_store_joined* stp_store_reserve_columns(stp_context* context, stp_splats* splats)
{
    uint64_t offsets[JOINED_COLUMNS];
    uint64_t end = place_columns(splats, splats->octave_count, offsets);
    unsigned char* memory = stp_alloc(context, (size_t)end);
    if (memory == NULL) {
        return NULL;
    }
    memset(memory, 0, sizeof(stp_store_joined));
    splats->positions = (uint16_t*)(void*)(memory + offsets[STP_OCTAVE_POSITIONS]);
    splats->normals = (int8_t*)(memory + offsets[STP_OCTAVE_NORMALS]);
    splats->materials = memory + offsets[STP_OCTAVE_MATERIALS];
    splats->colors = memory + offsets[STP_OCTAVE_COLORS];
    splats->coverages = memory + offsets[STP_OCTAVE_COVERAGES];
    bool shapes = (splats->columns & STP_SPLATS_SHAPES) != 0;
    bool ranges = (splats->columns & STP_SPLATS_RANGES) != 0;
    splats->shapes = shapes ? (uint32_t*)(void*)(memory + offsets[STP_OCTAVE_SHAPES]) : NULL;
    splats->ranges = ranges ? (uint32_t*)(void*)(memory + offsets[STP_OCTAVE_RANGES]) : NULL;
    bool errors = (splats->columns & STP_SPLATS_ERRORS) != 0;
    splats->errors = errors ? (uint32_t*)(void*)(memory + offsets[STP_OCTAVE_ERRORS]) : NULL;
    bool lights = splats->light_octaves != 0;
    splats->turns = lights ? (int8_t*)(memory + offsets[STP_OCTAVE_TURNS]) : NULL;
    splats->spreads = lights ? memory + offsets[STP_OCTAVE_SPREADS] : NULL;
    splats->groups = ranges ? (stp_splat_group*)(void*)(memory + offsets[JOINED_GROUPS]) : NULL;
    return (stp_store_joined*)(void*)memory;
}

void stp_store_copy_columns(const stp_splats* splats, const stp_splats* before,
                            uint32_t octave_count)
{
    assert(octave_count <= before->octave_count && octave_count <= splats->octave_count);
    uint64_t sizes[JOINED_COLUMNS];
    measure_columns(before, octave_count, sizes);
    memcpy(splats->positions, before->positions, (size_t)sizes[STP_OCTAVE_POSITIONS]);
    memcpy(splats->normals, before->normals, (size_t)sizes[STP_OCTAVE_NORMALS]);
    memcpy(splats->materials, before->materials, (size_t)sizes[STP_OCTAVE_MATERIALS]);
    memcpy(splats->colors, before->colors, (size_t)sizes[STP_OCTAVE_COLORS]);
    memcpy(splats->coverages, before->coverages, (size_t)sizes[STP_OCTAVE_COVERAGES]);
    if (splats->shapes != NULL) {
        memcpy(splats->shapes, before->shapes, (size_t)sizes[STP_OCTAVE_SHAPES]);
    }
    if (splats->ranges != NULL) {
        memcpy(splats->ranges, before->ranges, (size_t)sizes[STP_OCTAVE_RANGES]);
        memcpy(splats->groups, before->groups, (size_t)sizes[JOINED_GROUPS]);
    }
    if (splats->errors != NULL) {
        memcpy(splats->errors, before->errors, (size_t)sizes[STP_OCTAVE_ERRORS]);
    }
    if (sizes[STP_OCTAVE_SPREADS] != 0) {
        memcpy(splats->turns, before->turns, (size_t)sizes[STP_OCTAVE_TURNS]);
        memcpy(splats->spreads, before->spreads, (size_t)sizes[STP_OCTAVE_SPREADS]);
    }
}

void stp_store_octave_targets(const stp_splats* splats, uint32_t octave,
                              void* targets[STP_OCTAVE_COLUMNS])
{
    assert(octave < splats->octave_count);
    size_t first = stp_store_octave_begin(splats, octave);
    size_t entry = (size_t)stp_store_pyramid_begin(splats, octave);
    targets[STP_OCTAVE_POSITIONS] = splats->positions + 3 * first;
    targets[STP_OCTAVE_NORMALS] = splats->normals + 2 * first;
    targets[STP_OCTAVE_MATERIALS] = splats->materials + first;
    targets[STP_OCTAVE_COLORS] = splats->colors + 3 * entry;
    targets[STP_OCTAVE_COVERAGES] = splats->coverages + entry;
    targets[STP_OCTAVE_SHAPES] = splats->shapes != NULL ? splats->shapes + first : NULL;
    targets[STP_OCTAVE_RANGES] = splats->ranges != NULL ? splats->ranges + first : NULL;
    targets[STP_OCTAVE_ERRORS] = splats->errors != NULL ? splats->errors + first : NULL;
    bool lights = stp_has_light_normals(splats, octave);
    size_t light = (size_t)stp_light_normals_begin(splats, octave);
    targets[STP_OCTAVE_TURNS] = lights ? splats->turns + 2 * light : NULL;
    targets[STP_OCTAVE_SPREADS] = lights ? splats->spreads + light : NULL;
}

const stp_store_block* stp_store_octave_block(const stp_store* store, uint32_t index,
                                              uint32_t octave)
{
    const stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_octave* octaves = store->tables[STP_SECTION_OCTAVES];
    assert(octave < records[index].splats.octave_count);
    return stp_store_block_at(store, octaves[records[index].first_octave + octave].block);
}

bool stp_store_has_operators(const stp_store* store, uint32_t index, uint32_t octave_count)
{
    const stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    bool found = false;
    for (uint32_t k = 0; k < octave_count && k < records[index].splats.octave_count; ++k) {
        found = found ||
                stp_store_octave_block(store, index, k)->encoding == STP_STORE_ENCODING_OPERATORS;
    }
    return found;
}

stp_result stp_store_add_octave(stp_store* store, uint32_t index, uint32_t octave,
                                const stp_splats* splats)
{
    const stp_store_block* block = stp_store_octave_block(store, index, octave);
    stp_store_octave_span span = stp_store_span_of(splats, octave, block->encoding);
    stp_store_block_source source = {
        .block = block, .read = stp_store_read_mapped, .user = store, .set = splats};
    if (block->encoding == STP_STORE_ENCODING_OPERATORS) {
        source.waiting = stp_alloc(store->context, (size_t)stp_store_waiting_bytes(span.end));
        if (source.waiting == NULL) {
            return stp_fail_memory(store->context);
        }
    }
    void* targets[STP_OCTAVE_COLUMNS];
    uint64_t read_bytes = 0;
    stp_store_octave_targets(splats, octave, targets);
    const char* fault = stp_store_read_chunks(&source, &span, 0, stp_store_chunk_count(&span),
                                              targets, &read_bytes);
    if (fault == NULL) {
        fault = stp_store_color_octave(store, index, octave, splats, &source, &read_bytes);
    }
    stp_free(store->context, source.waiting);
    if (fault != NULL) {
        return stp_store_fail_block(store, block, fault);
    }
    stp_store_validator validator = stp_store_own_validator(store);
    stp_store_splat_data data = {span.end - span.first, targets[STP_OCTAVE_MATERIALS],
                                 targets[STP_OCTAVE_SHAPES], targets[STP_OCTAVE_RANGES]};
    stp_store_make_groups(splats, span.first, span.end);
    return stp_store_validate_splat_data(&validator, index, &data, store->directory.shading_count);
}

// Joins the first `octave_count` octaves, more than are ready, in new memory.
static stp_result join_octaves(stp_store* store, uint32_t index, uint32_t octave_count)
{
    stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    stp_store_set_record* record = &records[index];
    assert(octave_count > record->ready && octave_count <= record->whole);
    stp_splats made = record->splats;
    stp_store_truncate_splat_set(&made, octave_count);
    stp_store_joined* joined = stp_store_reserve_columns(store->context, &made);
    if (joined == NULL) {
        return stp_fail_memory(store->context);
    }
    if (record->ready != 0) {
        stp_store_copy_columns(&made, &record->splats, record->ready);
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

stp_result stp_store_get_splat_set_prefix(stp_store* store, uint32_t index, uint32_t octave_count,
                                          stp_splats* splats)
{
    if (index >= store->directory.set_count) {
        return stp_store_fail_index(store, "splat set", index);
    }
    const stp_store_set_record* records = store->tables[STP_SECTION_SPLAT_SETS];
    const stp_store_set_record* record = &records[index];
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
    *splats = record->splats;
    stp_store_truncate_splat_set(splats, octave_count);
    assert(splats->octave_count <= record->ready && "only octaves in memory");
    return STP_OK;
}

stp_result stp_store_get_splat_set(stp_store* store, uint32_t index, stp_splats* splats)
{
    return stp_store_get_splat_set_prefix(store, index, STP_OCTAVE_LIMIT, splats);
}
