// SPDX-License-Identifier: MIT
// Set cover: chooses few of many sets that cover all points, first greedily, then by relaxation (Wu
// and Kobbelt 2004).
#pragma once

#include "base/core/context.h"

/// Sets of points with sizes. Arrays of the caller are only read.
typedef struct stp_cover_problem {
    uint32_t point_count, set_count;
    const uint32_t* weights; ///< per point, at least 1
    const size_t* starts;    ///< per set, start of its points in `members`; and the end
    const uint32_t* members; ///< points; each at most once in a set
    const float* areas;      ///< per set: among covers with equally many sets, less area is better
    size_t* set_starts;      ///< per point, start of its sets in `sets`; and the end
    uint32_t* sets;          ///< sets that contain a point, ascending
} stp_cover_problem;

typedef struct stp_cover {
    uint32_t count;
    uint32_t* chosen; ///< sets
    uint32_t* places; ///< per set, its index in `chosen`; UINT32_MAX: not chosen
    uint32_t* depths; ///< per point: number of chosen sets that contain it
} stp_cover;

/// Lists the sets of each point. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_problem_index(stp_context* context, stp_cover_problem* problem);
void stp_cover_problem_destroy(stp_context* context, stp_cover_problem* problem);

/// Takes the set with the largest weight of uncovered points, until all points are covered; the
/// lower number on ties. Each point must be in a set.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_cover_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_cover_greedily(stp_context* context, const stp_cover_problem* problem,
                                           stp_cover* cover);
void stp_cover_destroy(stp_context* context, stp_cover* cover);

/// Chooses a set that is not chosen.
void stp_cover_add(const stp_cover_problem* problem, stp_cover* cover, uint32_t set);
/// Removes a chosen set, even if points are then uncovered. Moves the last chosen one to its place.
void stp_cover_remove(const stp_cover_problem* problem, stp_cover* cover, uint32_t set);
/// Whether all points of a chosen set are also in other chosen sets.
bool stp_cover_is_redundant(const stp_cover_problem* problem, const stp_cover* cover, uint32_t set);

/// Global relaxation: removes groups of neighbouring sets, covers their points again, and keeps the
/// result if it has no more sets. Exchanges for equally many sets lead to those that save one. Ends
/// when the count reaches `enough`, or stops falling. Uses all threads; results do not depend on
/// their number.
/// @param enough wanted count; 0: as few as possible
/// @param passes  caps the number of passes over all sets
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_relax(stp_context* context, const stp_cover_problem* problem,
                                        uint32_t enough, uint32_t passes, stp_cover* cover);

/// The same with exchanges that keep the count and lower the sum of the areas.
STP_MUST_USE stp_result stp_cover_tighten(stp_context* context, const stp_cover_problem* problem,
                                          uint32_t passes, stp_cover* cover);
