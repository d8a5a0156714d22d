// SPDX-License-Identifier: MIT
// Within hausdorff.c: finds the largest distance between samples, with a proof.
#pragma once

#include "measure/hausdorff.h"

/// Raises `max` and `farthest` to places that samples missed, and sets `bound`.
///
/// How far places of a triangle can be is known in two ways. A distance changes no faster than its
/// place moves: no place is farther than the middle, by more than the corner that is farthest from
/// the middle. And the distance to a single disk or triangle is convex: no place is farther from
/// the shape nearest to the middle than one of the corners is. Triangles that this does not rule
/// out are cut into four, until nothing is left that may be farther than a thousandth above the
/// maximum, or `places` more were measured. The same bits for any number of threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_hausdorff_prove(stp_context* context,
                                            const stp_measured_surface* surface,
                                            const stp_shape_tree* tree, uint64_t places,
                                            stp_hausdorff* hausdorff);
