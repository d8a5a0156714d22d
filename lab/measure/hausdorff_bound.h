// SPDX-License-Identifier: MIT
// Part of hausdorff.c: finds the largest distance between samples, with a proof.
#pragma once

#include "lab/measure/hausdorff.h"

/// Raises `max` and `farthest` to places that samples missed, and sets `bound`.
///
/// Two facts bound the distance within a triangle. A distance changes no faster than its place
/// moves: so no place is farther than the centre's distance plus the radius around the centre. And
/// the distance to a single disk or triangle is convex: so no place is farther from the shape
/// nearest to the centre than the farthest corner is. Triangles that these bounds do not rule out
/// are cut into four, until no distance can exceed the maximum by more than a thousandth, or
/// `places` more were measured. The same bits for any number of threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_hausdorff_prove(stp_context* context,
                                            const stp_measured_surface* surface,
                                            const stp_shape_tree* tree, uint64_t places,
                                            stp_hausdorff* hausdorff);
