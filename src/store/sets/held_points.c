// SPDX-License-Identifier: MIT
// Point sets held by a set of splats. The set contains each point once, so the file stores no
// second copy. Point columns are made from the set on request.
#include "base/splats/octahedral.h"
#include "base/splats/splat_columns.h"
#include "store/file/internal.h"

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
    bool hides;                        ///< coverage 0 hides a splat (coloring.h)
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

stp_result stp_store_make_held_points(stp_store* store, uint32_t index,
                                      stp_store_point_record* record)
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
                        "%s: ends before the last octave of the surfels that are point set %u",
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
