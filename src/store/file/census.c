// SPDX-License-Identifier: MIT
#include "store/file/store.h"

#include <assert.h>
#include <stdlib.h>

// By triangle count, largest first; ties by position.
static int compare_candidates(const void* left, const void* right)
{
    const stp_store_census_candidate* a = *(const stp_store_census_candidate* const*)left;
    const stp_store_census_candidate* b = *(const stp_store_census_candidate* const*)right;
    if (a->triangles != b->triangles) {
        return a->triangles > b->triangles ? -1 : 1;
    }
    return a < b ? -1 : a > b ? 1 : 0;
}

// Marks the candidates that become separate parts.
static bool choose(stp_context* context, const stp_store_census_candidate* candidates, size_t count,
                   bool* chosen)
{
    const stp_store_census_candidate** sorted =
        STP_NEW_ARRAY(context, const stp_store_census_candidate*, count);
    if (sorted == NULL) {
        return false;
    }
    for (size_t i = 0; i < count; ++i) {
        sorted[i] = &candidates[i];
    }
    qsort(sorted, count, sizeof(sorted[0]), compare_candidates);
    for (size_t i = 0; i < count && i < STP_STORE_SCENE_PARTS; ++i) {
        chosen[sorted[i] - candidates] = true;
    }
    stp_free(context, sorted);
    return true;
}

stp_result stp_store_census_create(stp_context* context,
                                   const stp_store_census_candidate* candidates, size_t count,
                                   stp_store_census* census)
{
    *census = (stp_store_census){0};
    if (count == 0) {
        return STP_OK;
    }
    size_t own = count < STP_STORE_SCENE_PARTS ? count : STP_STORE_SCENE_PARTS;
    bool* chosen = STP_NEW_ZEROED(context, bool, count);
    uint32_t* members = STP_NEW_ARRAY(context, uint32_t, count);
    stp_store_census_part* parts = STP_NEW_ZEROED(context, stp_store_census_part, own + 1);
    if (chosen == NULL || members == NULL || parts == NULL ||
        !choose(context, candidates, count, chosen)) {
        stp_free(context, chosen);
        stp_free(context, members);
        stp_free(context, parts);
        return stp_fail_memory(context);
    }
    // those of "others" come last
    size_t next = 0, other = own;
    for (size_t i = 0; i < count; ++i) {
        size_t at = chosen[i] ? next++ : other++;
        members[at] = candidates[i].object;
        if (chosen[i]) {
            parts[at].name = candidates[i].name;
            parts[at].members = members + at;
            parts[at].member_count = 1;
        }
    }
    assert(next == own && other == count && "the chosen candidates are exactly `own`");
    if (count > own) {
        parts[own].name = "others";
        parts[own].members = members + own;
        parts[own].member_count = (uint32_t)(count - own);
    }
    stp_free(context, chosen);
    census->parts = parts;
    census->members = members;
    census->part_count = (uint32_t)(own + (count > own ? 1 : 0));
    return STP_OK;
}

void stp_store_census_destroy(stp_context* context, stp_store_census* census)
{
    stp_free(context, census->members);
    stp_free(context, census->parts);
    *census = (stp_store_census){0};
}
