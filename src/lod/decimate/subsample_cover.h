// SPDX-License-Identifier: MIT
// Choosing few of many sets so that they cover all points: greedily, and then better (Wu and
// Kobbelt 2004).
#pragma once

#include "base/context.h"

/// Sets of points with sizes. Arrays of the caller are only read.
typedef struct stp_cover_problem {
    uint32_t point_count, set_count;
    const uint32_t* weights; ///< of each point, at least 1
    const size_t* starts;    ///< of each set in `members`, and the end
    const uint32_t* members; ///< points; each at most once in a set
    const float* areas;      ///< of each set: of covers with as many sets, less area is better
    size_t* set_starts;      ///< of each point in `sets`, and the end
    uint32_t* sets;          ///< those that hold a point, ascending
} stp_cover_problem;

typedef struct stp_cover {
    uint32_t count;
    uint32_t* chosen; ///< sets
    uint32_t* places; ///< of each set in `chosen`; UINT32_MAX: not chosen
    uint32_t* depths; ///< of each point: how many of the chosen sets hold it
} stp_cover;

/// Lists the sets of each point. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_problem_index(stp_context* context, stp_cover_problem* problem);
void stp_cover_problem_destroy(stp_context* context, stp_cover_problem* problem);

/// Takes the set with the greatest weight of points that are not covered yet, until all are. Of
/// equal ones the lower number is taken. Each point must be in a set.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_cover_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_cover_greedily(stp_context* context, const stp_cover_problem* problem,
                                           stp_cover* cover);
void stp_cover_destroy(stp_context* context, stp_cover* cover);

void stp_cover_add(const stp_cover_problem* problem, stp_cover* cover, uint32_t set);
void stp_cover_remove(const stp_cover_problem* problem, stp_cover* cover, uint32_t set);
/// Whether all points of a chosen set are in other chosen ones too.
bool stp_cover_is_redundant(const stp_cover_problem* problem, const stp_cover* cover, uint32_t set);

/// Global relaxation: takes neighbouring sets out together, covers their points anew, and keeps
/// what has no more sets. Exchanges for as many sets lead on to those that save one. Ends when the
/// count has reached `enough`, or falls no more. On all threads; results do not depend on their
/// number.
/// @param enough  the count that is wanted; 0: as few as possible
/// @param passes  caps the number of passes over all sets
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_relax(stp_context* context, const stp_cover_problem* problem,
                                        uint32_t enough, uint32_t passes, stp_cover* cover);

/// The same with exchanges that keep the count and lower the sum of the areas.
STP_MUST_USE stp_result stp_cover_tighten(stp_context* context, const stp_cover_problem* problem,
                                          uint32_t passes, stp_cover* cover);
