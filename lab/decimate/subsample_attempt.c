// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_attempt.h"

#include <assert.h>

enum {
    CANDIDATES = 24, ///< initial candidates per wanted splat
    CROWD = 8,       ///< maximum points of a candidate, relative to the mean per wanted splat
    CROWD_MIN = 16,  ///< added to that maximum
    PASSES_MAX = 24, ///< maximum passes of the relaxation
};

stp_result stp_subsample_attempt_make(stp_context* context, const stp_subsample_field* field,
                                      double tolerance, uint32_t target, stp_subsample_attempt* a)
{
    assert(target > 0 && tolerance >= 0.0);
    uint64_t seeds = (uint64_t)CANDIDATES * target;
    uint64_t maximum = (uint64_t)CROWD * field->count / target + CROWD_MIN;
    *a = (stp_subsample_attempt){.made = true, .tolerance = tolerance};
    stp_result result = stp_subsample_grow(
        context, field, tolerance, seeds < field->count ? (uint32_t)seeds : field->count,
        maximum < field->count ? (uint32_t)maximum : field->count, &a->candidates);
    if (result != STP_OK) {
        return result;
    }
    uint32_t count = a->candidates.count;
    a->areas = STP_NEW_ARRAY(context, float, (size_t)count + 1);
    if (a->areas == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        a->areas[i] = a->candidates.shapes[i].major * a->candidates.shapes[i].minor;
    }
    a->problem = (stp_cover_problem){.point_count = field->count,
                                     .set_count = count,
                                     .weights = field->weights,
                                     .starts = a->candidates.starts,
                                     .members = a->candidates.members,
                                     .areas = a->areas};
    result = stp_cover_problem_index(context, &a->problem);
    return result == STP_OK ? stp_cover_greedily(context, &a->problem, &a->cover) : result;
}

stp_result stp_subsample_attempt_relax(stp_context* context, uint32_t enough,
                                       stp_subsample_attempt* a)
{
    assert(a->made && a->cover.count <= a->candidates.count);
    return stp_cover_relax(context, &a->problem, enough, PASSES_MAX, &a->cover);
}

void stp_subsample_attempt_destroy(stp_context* context, stp_subsample_attempt* a)
{
    stp_subsample_candidates_destroy(context, &a->candidates);
    stp_cover_problem_destroy(context, &a->problem);
    stp_cover_destroy(context, &a->cover);
    stp_free(context, a->areas);
    *a = (stp_subsample_attempt){0};
}
