// SPDX-License-Identifier: MIT
// Candidate splats: each grows from a point as far as the tolerance allows (Wu and Kobbelt 2004).
#pragma once

#include "lab/decimate/subsample_field.h"

/// The plane and the shape of a candidate. Distances in its plane are measured so that its ellipse
/// is a circle.
typedef struct stp_subsample_candidate {
    stp_vec3 center; ///< centre of the slab that contains all covered points
    stp_vec3 normal; ///< unit normal
    stp_vec3 axis;   ///< unit direction of the major axis
    float ratio;     ///< ratio of the axes without margins, 1 or more
    float major, minor;
} stp_subsample_candidate;

/// Candidates, and the points each one covers.
typedef struct stp_subsample_candidates {
    uint32_t count;
    stp_subsample_candidate* shapes;
    size_t* starts;    ///< per candidate, start of its points in `members`; and the end
    uint32_t* members; ///< points
    size_t shape_capacity, start_capacity;
} stp_subsample_candidates;

/// Grows candidates until each point is covered: from evenly spread points, then from all uncovered
/// points. Uses all threads; results do not depend on their number.
/// @param tolerance half the thickness of the slab that contains the points of a splat; 0 or more
/// @param wanted number of initial seeds
/// @param maximum      caps the points of a candidate; 1 or more
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_subsample_candidates_destroy,
///         also after a failure
STP_MUST_USE stp_result stp_subsample_grow(stp_context* context, const stp_subsample_field* field,
                                           double tolerance, uint32_t wanted, uint32_t maximum,
                                           stp_subsample_candidates* candidates);
void stp_subsample_candidates_destroy(stp_context* context, stp_subsample_candidates* candidates);

static inline stp_ellipse stp_subsample_ellipse(const stp_subsample_candidate* c)
{
    return (stp_ellipse){c->center, c->normal, stp_scale(c->axis, c->major), c->minor};
}
