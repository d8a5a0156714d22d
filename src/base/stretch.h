// SPDX-License-Identifier: MIT
// How much a map stretches lengths.
#pragma once

#include "base/math.h"

/// The largest factor by which a map stretches any length: never less than it, at most 1 % more, and exact where the
/// map only turns, mirrors and scales evenly. 0 where it flattens everything or is not finite.
double stp_affine_stretch(const stp_affine* a);
