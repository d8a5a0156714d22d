// SPDX-License-Identifier: MIT
// Largest scale factor of a transform.
#pragma once

#include "base/math/math.h"

/// Largest factor by which a transform stretches a length: never too small, at most 1 % too large,
/// and exact for rotations, mirroring and uniform scales. 0 if it collapses everything to a point
/// or is not finite.
double stp_affine_stretch(const stp_affine* a);
