// SPDX-License-Identifier: MIT
// Units of measures (stipple/measure.h), for those who write numbers themselves.
#pragma once

#include "base/math.h"

#include <stipple/measure.h>

/// Factor from lengths of the file to lengths in the unit that is shown.
double stp_measure_factor(const stp_measuring* measuring);

/// Name of the unit that is shown: "m", "mm", "cm", "km", "in", "ft", "yd", "mi", "us-ft"; "" where the unit is none of these or unknown.
const char* stp_measure_unit(const stp_measuring* measuring);
