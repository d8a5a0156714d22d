// SPDX-License-Identifier: MIT
// Cover of all points by splats within one tolerance: the method of Wu and Kobbelt 2004, except the
// final fit.
#pragma once

#include "lab/decimate/subsample_fit.h"

enum { STP_SUBSAMPLE_POINTS_MAX = 1 << 27 };

typedef struct stp_subsample_attempt {
    bool made;
    double tolerance; ///< half the thickness of the slab that contains the points of a splat
    stp_subsample_candidates candidates;
    float* areas; ///< areas of the candidates, up to a common factor
    stp_cover_problem problem;
    stp_cover cover;
} stp_subsample_attempt;

/// Grows candidates and covers all points greedily.
/// @param target approximate number of wanted splats: bounds the number of candidates and the
/// points of each
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_subsample_attempt_destroy, also
///         after a failure
STP_MUST_USE stp_result stp_subsample_attempt_make(stp_context* context,
                                                   const stp_subsample_field* field,
                                                   double tolerance, uint32_t target,
                                                   stp_subsample_attempt* attempt);
/// Improves the cover until it has `enough` splats, or no fewer can be found; 0: as few as
/// possible.
STP_MUST_USE stp_result stp_subsample_attempt_relax(stp_context* context, uint32_t enough,
                                                    stp_subsample_attempt* attempt);
void stp_subsample_attempt_destroy(stp_context* context, stp_subsample_attempt* attempt);
