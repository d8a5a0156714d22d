// SPDX-License-Identifier: MIT
// Units of measures (stipple/measure.h), for those who write numbers themselves.
#pragma once

#include "base/math/math.h"

#include <stipple/measure.h>

/// Factor from lengths of the file to lengths in the displayed unit.
double stp_measure_factor(const stp_measuring* measuring);

/// Name of the displayed unit: "m", "mm", "cm", "km", "in", "ft", "yd", "mi", "us-ft"; "" if it is
/// none of these or unknown.
const char* stp_measure_unit(const stp_measuring* measuring);
