// SPDX-License-Identifier: MIT
// Octaves and prefix tables of sets whose splats have ranges of levels.
#pragma once

#include "base/splats/splat_columns.h"

/// Sets the octave ends of a set of `count` splats. Octaves grow fourfold.
void stp_set_octaves_make(stp_splats* set);

/// Fills the prefix table of a set with octaves. A prefix reaches the highest level of the splats
/// after it, rounded up as ranges are.
/// @param highest_left for each splat an upper bound, never rising, of the highest levels of it and
///         all after it
/// @param scale factor from those bounds to levels
/// @param reach the level that all splats reach
void stp_set_table_make(stp_splats* set, const float* highest_left, float scale, float reach);
