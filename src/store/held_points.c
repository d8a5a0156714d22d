// SPDX-License-Identifier: MIT
// Points that a set of splats holds: the set contains each point once, so the file stores no other
// copy. Columns of points are made from the set on request.
#include "base/octahedral.h"
#include "base/splat_place.h"
#include "store/internal.h"

#include <string.h>

enum { OPAQUE = 255 };

/// Columns made of a set, in one piece of memory.
typedef struct columns {
    float* positions;
    int16_t* normals;
    uint8_t* colors;
} columns;

static void fill(const stp_store* store, const stp_splats* set, const columns* to)
{
    uint64_t finest = stp_store_colors_begin(set, set->octave_count - 1);
    const uint8_t *colors = set->colors + 3 * finest, *coverages = set->coverages + finest;
    bool hides = stp_store_is_colored(store); // coverage 0 then hides a splat (coloring.h)
    for (size_t i = 0; i < set->count; ++i) {
        stp_vec3 place = stp_to_float(stp_splat_place(set, i));
        memcpy(to->positions + 3 * i, &place, sizeof(place));
        memcpy(to->colors + 4 * i, colors + 3 * i, 3);
        to->colors[4 * i + 3] = hides && coverages[i] == 0 ? 0 : OPAQUE;
        stp_octahedral_encode16(stp_octahedral_decode(set->normals[2 * i], set->normals[2 * i + 1]),
                                to->normals + 2 * i);
    }
}

stp_result stp_store_make_held_points(stp_store* store, uint32_t index,
                                      stp_store_point_record* record)
{
    stp_splats set;
    stp_result result = stp_store_get_surfels(store, record->points.held_by - 1, &set);
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
