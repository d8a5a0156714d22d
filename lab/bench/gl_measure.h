// SPDX-License-Identifier: MIT
// GPU memory copy speed, for comparison with drawing.
#pragma once

#include "program/present/headless.h"

#include <stdint.h>

/// Bytes per second that the device copies within its memory, counting reads and writes. 0: not
/// measurable.
double gl_measure_copy(const stp_headless* headless, uint64_t size);
