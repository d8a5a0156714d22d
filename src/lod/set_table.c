// SPDX-License-Identifier: MIT
#include "base/splats/splat_codes.h"
#include "lod/set_columns.h"

#include <assert.h>

enum {
    FIRST_OCTAVE = 64, ///< splats
    OCTAVE_GROWTH = 4,
    FINEST_STEP = 8, ///< finest step of the prefix table: an eighth more splats
};

void stp_set_octaves_make(stp_splats* set)
{
    assert(set->octave_count == 0 && "octaves are made once");
    for (uint64_t end = FIRST_OCTAVE; end < set->count && set->octave_count + 1 < STP_OCTAVE_LIMIT;
         end *= OCTAVE_GROWTH) {
        set->octave_ends[set->octave_count++] = (uint32_t)end;
    }
    assert(set->octave_count < STP_OCTAVE_LIMIT);
    set->octave_ends[set->octave_count++] = set->count;
}

/// Count of the next breakpoint: larger by 1 / `part`. Octave ends are always breakpoints, because
/// sets are loaded by octaves.
static uint32_t next_count(const stp_splats* s, uint32_t count, uint32_t part)
{
    uint64_t next = (uint64_t)count + (count / part > 1 ? count / part : 1);
    for (uint32_t k = 0; k < s->octave_count; ++k) {
        uint32_t end = s->octave_ends[k];
        next = count < end && end < next ? end : next;
    }
    assert(count < next && (count >= s->count || next <= s->count));
    return (uint32_t)next;
}

/// The finest step for which the table holds all breakpoints.
static uint32_t choose_part(const stp_splats* s)
{
    for (uint32_t part = FINEST_STEP; part > 1; --part) {
        uint32_t steps = 1;
        for (uint32_t count = 1; count < s->count; count = next_count(s, count, part)) {
            steps += 1;
        }
        if (steps <= STP_PREFIX_TABLE_SIZE) {
            return part;
        }
    }
    return 1; // doubling: 32 steps, and the octaves'
}

void stp_set_table_make(stp_splats* set, const float* highest_left, float scale, float reach)
{
    stp_prefix_table* table = &set->table;
    assert(table->size == 0 && set->octave_count > 0 && "octaves come first, tables once");
    uint32_t part = choose_part(set);
    for (uint32_t count = 1; count < set->count; count = next_count(set, count, part)) {
        float left = stp_range_level(stp_range_code(0.0f, scale * highest_left[count]) >> 16);
        assert(table->size < STP_PREFIX_TABLE_SIZE - 1 && "choose_part leaves room");
        assert((table->size == 0 || !(left > table->radius[table->size - 1])) &&
               "bounds never rise");
        table->count[table->size] = count;
        table->radius[table->size++] = left > reach ? left : reach;
    }
    table->count[table->size] = set->count;
    table->radius[table->size++] = reach;
}
