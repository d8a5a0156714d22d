// SPDX-License-Identifier: MIT
// Point sets: read in place, or made on request from the set of splats that holds them. Such a set
// contains each point once, so the file stores no second copy.
#include "base/splats/octahedral.h"
#include "base/splats/splat_columns.h"
#include "store/file/block_table.h"
#include "store/sets/sets_internal.h"

#include <assert.h>
#include <string.h>

enum { OPAQUE = 255, GRAIN = 16384 };

/// Columns made from a set, in one allocation.
typedef struct columns {
    float* positions;
    int16_t* normals;
    uint8_t* colors;
} columns;

/// A set on its way into columns.
typedef struct filling {
    const stp_splats* set;
    const uint8_t *colors, *coverages; ///< entries of the set's finest octave
    bool hides;                        ///< coverage 0 hides a splat (point_attributes.h)
    columns to;
} filling;

static void fill_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const filling* f = user;
    const stp_splats* set = f->set;
    for (size_t i = begin; i < end; ++i) {
        stp_vec3 place = stp_to_float(stp_splat_place(set, i));
        memcpy(f->to.positions + 3 * i, &place, sizeof(place));
        memcpy(f->to.colors + 4 * i, f->colors + 3 * i, 3);
        f->to.colors[4 * i + 3] = f->hides && f->coverages[i] == 0 ? 0 : OPAQUE;
        stp_octahedral_encode16(stp_octahedral_decode(set->normals[2 * i], set->normals[2 * i + 1]),
                                f->to.normals + 2 * i);
    }
}

static void fill(const stp_store* store, const stp_splats* set, const columns* to)
{
    assert(set->octave_count >= 1);
    uint64_t finest = stp_store_colors_begin(set, set->octave_count - 1);
    filling f = {.set = set,
                 .colors = set->colors + 3 * finest,
                 .coverages = set->coverages + finest,
                 .hides = stp_store_is_colored(store),
                 .to = *to};
    stp_parallel_for(store->context, set->count, GRAIN, fill_points, &f);
}

// Gives a point record the columns of the set that holds its points. The record owns the memory.
static stp_result make_held_points(stp_store* store, uint32_t index, stp_store_point_record* record)
{
    assert(record->points.held_by != 0);
    stp_splats set;
    stp_result result = stp_store_get_splat_set(store, record->points.held_by - 1, &set);
    if (result != STP_OK) {
        return result;
    }
    size_t count = record->points.point_count;
    if (set.count != count) {
        return stp_fail(store->context, STP_ERROR_TRUNCATED,
                        "%s: ends before the last octave of the splats that are point set %u",
                        store->path, index);
    }
    unsigned char* memory =
        stp_alloc_array(store->context, count + 1, 3 * sizeof(float) + 2 * sizeof(int16_t) + 4);
    if (memory == NULL) {
        return stp_fail_memory(store->context);
    }
    columns made = {.positions = (float*)(void*)memory};
    made.normals = (int16_t*)(void*)(memory + 3 * sizeof(float) * count);
    made.colors = memory + (3 * sizeof(float) + 2 * sizeof(int16_t)) * count;
    if (count != 0) {
        fill(store, &set, &made);
    }
    record->made = memory;
    record->points.positions = made.positions;
    record->points.normals = made.normals;
    record->points.colors = made.colors;
    record->checked = true;
    return STP_OK;
}

void stp_store_release_points(stp_store* store)
{
    stp_store_point_record* points = store->tables[STP_SECTION_POINT_SETS];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_POINT_SETS]; ++i) {
        stp_free(store->context, points[i].colored);
        stp_free(store->context, points[i].made);
        points[i].colored = NULL;
        points[i].made = NULL;
        points[i].checked = false;
    }
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
        stp_result result = make_held_points(store, index, record);
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
