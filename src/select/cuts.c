// SPDX-License-Identifier: MIT
// States of progressive sets (base/splats/progressive.h) in a view: where a splat count divides a set.
// Finding this reads the ranges of all splats before it, so results are cached for the next view,
// which often has the same items.
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "select/rule.h"

#include <assert.h>

/// A cached state.
typedef struct stp_select_cut {
    uint32_t set, here, wanted; ///< key; `here`: loaded splats of the searched prefix
    stp_progressive_cut cut;
} stp_select_cut;

/// Number of splats of a prefix drawn at the levels of a cut. In a set that is not progressive,
/// they differ from a state.
static uint32_t count_drawn(const uint32_t* ranges, const stp_progressive_cut* cut)
{
    uint32_t below = stp_bits_of_float(cut->below), level = stp_bits_of_float(cut->level);
    uint32_t count = 0;
    for (uint32_t i = 0; i < cut->end; ++i) {
        uint32_t at = i < cut->divide ? below : level;
        count += at >= (ranges[i] & 0xFFFFu) << 15 && at <= ranges[i] >> 16 << 15 ? 1 : 0;
    }
    return count;
}

/// @return a cut of no splats if the set has no states
static stp_progressive_cut find(const uint32_t* ranges, uint32_t here, uint32_t wanted)
{
    stp_progressive_cut cut = stp_progressive_find_cut(ranges, here, wanted);
    if (cut.splats > wanted) {
        cut = stp_progressive_find_cut(ranges, wanted, wanted);
    }
    return count_drawn(ranges, &cut) == cut.splats ? cut : (stp_progressive_cut){0};
}

stp_result stp_select_count_states(stp_store* store, uint32_t set, uint32_t* maximum, bool* ends)
{
    const stp_splats* whole = stp_store_describe_splat_set(store, set);
    uint32_t base = 0;
    stp_splats got = {0};
    for (uint32_t k = 1; k <= whole->octave_count && base == got.count; ++k) {
        stp_result result = stp_store_get_splat_set_prefix(store, set, k, &got);
        if (result != STP_OK || got.ranges == NULL) {
            *maximum = whole->count;
            *ends = false;
            return result;
        }
        while (base < got.count && got.ranges[base] >> 16 >= STP_RANGE_INFINITE) {
            base += 1;
        }
    }
    assert(base <= got.count && got.count <= whole->count);
    *ends = base < got.count || got.count == whole->count;
    base = base > 0 ? base : 1;           // nothing of the set is loaded
    *maximum = (whole->count + base) / 2; // each split replaces one splat by two
    assert(*maximum <= whole->count);
    return STP_OK;
}

stp_result stp_select_max_count(stp_selection* s, uint32_t node, uint32_t* maximum)
{
    uint32_t* known = &s->list->graph->maximum[node];
    uint32_t set = stp_select_set_of(s, node);
    *maximum = *known > 0 ? *known : stp_store_describe_splat_set(s->store, set)->count;
    if (*known > 0 || s->rule != &stp_select_rule_splits) {
        return STP_OK;
    }
    bool ends = false;
    stp_result result = stp_select_count_states(s->store, set, maximum, &ends);
    *known = result == STP_OK && ends ? *maximum : 0;
    return result;
}

/// Ensures room for one more than `count`.
static bool make_room(stp_selection* s, size_t count)
{
    stp_draw_list* list = s->list;
    if (count < list->cut_capacity) {
        return true;
    }
    size_t before = list->cut_capacity;
    if (!STP_MAKE_ROOM(s->context, list->cuts, list->cut_capacity, count + 1)) {
        return false;
    }
    for (size_t i = before; i < list->cut_capacity; ++i) {
        list->cuts[i] = (stp_select_cut){.set = STP_STORE_NONE};
    }
    return true;
}

stp_result stp_select_cut_item(stp_selection* s, uint32_t wanted, stp_draw_item* item, bool* found)
{
    const stp_splats* known = stp_store_describe_splat_set(s->store, item->index);
    uint32_t octaves = stp_store_octaves_for(known, item->prefix);
    stp_splats got;
    stp_result result = stp_store_get_splat_set_prefix(s->store, item->index, octaves, &got);
    *found = false;
    if (result != STP_OK || got.ranges == NULL) {
        return result;
    }
    assert(wanted > 0);
    if (!make_room(s, s->cut_count)) {
        return stp_fail_memory(s->context);
    }
    stp_select_cut* kept = &s->list->cuts[s->cut_count++];
    uint32_t here = item->prefix < got.count ? item->prefix : got.count;
    if (kept->set != item->index || kept->here != here || kept->wanted != wanted) {
        *kept = (stp_select_cut){item->index, here, wanted, find(got.ranges, here, wanted)};
    }
    const stp_progressive_cut* cut = &kept->cut;
    *found = cut->splats > 0;
    assert(cut->splats <= cut->end && cut->end <= here && "the state is in the loaded prefix");
    assert(cut->splats <= wanted);
    if (!*found) {
        return STP_OK;
    }
    item->prefix = item->full_prefix = cut->end;
    item->split_count = cut->end - cut->splats;
    item->divide = cut->divide;
    item->level_below = cut->below;
    item->level_min = cut->level;
    item->radius = stp_max(cut->level, known->candidate_radius);
    return STP_OK;
}
