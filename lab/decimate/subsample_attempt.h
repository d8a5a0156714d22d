// SPDX-License-Identifier: MIT
// Cover of all points by splats within one tolerance: the method of Wu and Kobbelt 2004, except the
// final fit.
#pragma once

#include "lab/decimate/subsample_cover.h"
#include "lab/decimate/subsample_grow.h"

// The region around a point that one splat can represent.

/// Memory of one worker, for regions of one field.
typedef struct stp_subsample_scratch {
    stp_context* context;
    uint32_t* visited; ///< per point: number of the last region that reached it
    uint32_t region;
    uint64_t* heap; ///< points to visit: distance, then index
    size_t heap_capacity;
    uint32_t heap_count;
    uint32_t* members[2]; ///< points of the best region so far, and of the one that is tried
    size_t capacity[2];
} stp_subsample_scratch;

/// Grows a circle from a point over the neighbour graph until the next point does not fit in the
/// slab. Then fits a quadric to its points, and grows an ellipse with the quadric's tangent plane
/// and curvatures. Keeps the larger region.
/// @param members receives the covered points, in scratch memory valid until the next call
/// @return the number of points, the seed first; 0: out of memory (not logged)
uint32_t stp_subsample_find_region(const stp_subsample_field* field, stp_subsample_scratch* scratch,
                                   uint32_t seed, double tolerance, uint32_t maximum,
                                   stp_subsample_candidate* shape, const uint32_t** members);

// Fits final splats of chosen candidates: no larger than their points need.

/// A cover by candidates of a field.
typedef struct stp_subsample_choice {
    const stp_subsample_field* field;
    const stp_subsample_candidates* candidates;
    const stp_cover_problem* problem;
    const stp_cover* cover;
} stp_subsample_choice;

/// Assigns each point to one of the chosen candidates that cover it, moves each candidate in its
/// plane to the centre of its points, and repeats. The final ellipses contain their points with
/// margins. A candidate without points has no splat. Uses all threads; results do not depend on
/// their number.
/// @param ellipses space for all chosen ones
/// @param colors 3 per splat, sRGB: means, in linear light, of the covered points; white without
/// colours
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_subsample_fit(stp_context* context, const stp_subsample_choice* choice,
                                          stp_ellipse* ellipses, uint8_t* colors, uint32_t* count);

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
