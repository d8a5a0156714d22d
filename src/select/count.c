// SPDX-License-Identifier: MIT
// Distributes a splat count (stp_quality.splat_count) over the topmost sets of the shown scene.
//
// Each set gets one splat; the rest is proportional to the areas of the sets, so that splats are
// about equally large everywhere. Shares depend on the scene and its visible objects, not on the
// eye. They follow Sainte-Lague's method: one more splat gives one set one more, and changes no
// other set.
#include "base/splats/prefix_table.h"
#include "select/rule.h"
#include "select/select_internal.h"

#include <assert.h>

#define MIN_PART 1e-12 ///< minimum share of the total area per set

typedef struct stp_select_share {
    stp_select_entry at; ///< entry of the set's node
    uint32_t maximum;    ///< splats available
    uint32_t count;      ///< splats assigned
    double area;         ///< share of the total area
} stp_select_share;

/// Area that a set represents, in scene units. Estimated from a quarter of its splats: their
/// spacing is their coverage radius, or equals their errors (STP_SPLATS_RANGES). A whole set may
/// have a coverage radius of 0.
static double find_area(const stp_splats* splats, const stp_affine* transform)
{
    uint32_t count = splats->count / 4 + 1;
    double radius = (double)stp_prefix_table_radius(&splats->table, count);
    radius = radius < (double)FLT_MAX ? radius : 0.0; // no table
    radius = fmax(radius, (double)splats->step) * stp_affine_scale(transform);
    return (double)count * radius * radius;
}

stp_result stp_select_note_set(stp_selection* s, const stp_select_entry* at)
{
    stp_draw_list* list = s->list;
    uint32_t set = stp_select_set_of(s, at->node);
    stp_select_share share = {.at = *at};
    stp_result result = stp_select_max_count(s, at->node, &share.maximum);
    if (result != STP_OK) {
        return result;
    }
    assert(share.maximum > 0 && "the set has splats");
    assert(s->share_count <= list->share_capacity);
    if (s->share_count == list->share_capacity) {
        if (!STP_MAKE_ROOM(s->context, list->shares, list->share_capacity, s->share_count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    share.area = find_area(stp_store_describe_splat_set(s->store, set), &at->transform);
    list->shares[s->share_count++] = share;
    return STP_OK;
}

/// Normalizes areas to shares of their sum.
static void normalize_areas(stp_select_share* shares, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) {
        sum += shares[i].area;
    }
    bool known = sum > 0.0 && sum < HUGE_VAL;
    for (size_t i = 0; i < count; ++i) {
        shares[i].area = known ? fmax(shares[i].area / sum, MIN_PART) : 1.0 / (double)count;
    }
}

/// Splats of a set if the total area has `density` of them.
static uint32_t count_at(const stp_select_share* share, double density, uint32_t low,
                         uint32_t maximum)
{
    uint32_t high = share->maximum < maximum ? share->maximum : maximum;
    assert(low <= high && "a set gets what every set gets");
    double count = floor(share->area * density + 0.5);
    return count < (double)high ? (count > (double)low ? (uint32_t)count : low) : high;
}

static uint64_t count_all_at(const stp_select_share* shares, size_t count, double density,
                             uint32_t low, uint32_t maximum)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += count_at(&shares[i], density, low, maximum);
    }
    return sum;
}

/// Distributes `wanted` splats, at most those available: each set gets from `low` to `maximum`,
/// within its own limit.
static void share_out(stp_select_share* shares, size_t count, uint64_t wanted, uint32_t low,
                      uint32_t maximum)
{
    double below = 0.0, density = (double)wanted + 1.0;
    assert((uint64_t)low * count <= wanted);
    assert(count_all_at(shares, count, HUGE_VAL, low, maximum) >= wanted &&
           "else the loop has no end");
    while (count_all_at(shares, count, density, low, maximum) < wanted) {
        below = density;
        density *= 2.0;
    }
    for (;;) { // smallest density that gives this many
        double middle = below + 0.5 * (density - below);
        if (!(middle > below && middle < density)) {
            break;
        }
        uint64_t sum = count_all_at(shares, count, middle, low, maximum);
        *(sum < wanted ? &below : &density) = middle;
        if (sum == wanted) {
            break;
        }
    }
    uint64_t left = wanted;
    for (size_t i = 0; i < count; ++i) {
        shares[i].count = count_at(&shares[i], below, low, maximum);
        left -= shares[i].count;
    }
    for (size_t i = 0; i < count && left > 0; ++i) { // among equals, the first ones
        uint32_t more = count_at(&shares[i], density, low, maximum) - shares[i].count;
        more = left < more ? (uint32_t)left : more;
        shares[i].count += more;
        left -= more;
    }
    assert(left == 0 && "all splats are distributed");
}

static stp_result add_share(stp_selection* s, const stp_select_share* share)
{
    const stp_select_entry* at = &share->at;
    assert(share->count > 0 && share->count <= share->maximum);
    stp_set_use use = stp_select_begin_use(s, s->rule, stp_select_set_of(s, at->node));
    use.switch_depth = 0.0; // nothing below is drawn
    stp_boxd box = stp_select_place_box(&at->transform, &s->directory->nodes[at->node].bounds);
    stp_box_visibility sight;
    (void)stp_select_is_in_view(s, &box, &sight); // whether in view or not
    s->rule->choose_count(&use, share->count);
    stp_result result = s->streams ? stp_select_limit_use(s, at, &sight, &use) : STP_OK;
    if (result == STP_OK && use.count == share->count) {
        result = stp_select_count_coarse(s, at, &sight, share->count, &use);
    }
    return result == STP_OK && use.count > 0 ? use.rule->add(s, at, &use, &sight) : result;
}

stp_result stp_select_add_count(stp_selection* s)
{
    stp_select_share* shares = s->list->shares;
    size_t count = s->share_count;
    uint64_t wanted = s->quality->splat_count, all = 0;
    for (size_t i = 0; i < count; ++i) {
        all += shares[i].maximum;
    }
    wanted = wanted < all ? wanted : all;
    normalize_areas(shares, count);
    if (wanted < count) {
        share_out(shares, count, wanted, 0, 1);
    } else {
        share_out(shares, count, wanted, 1, UINT32_MAX);
    }
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        result = shares[i].count > 0 ? add_share(s, &shares[i]) : STP_OK;
    }
    return result;
}
