// SPDX-License-Identifier: MIT
// What a graphics processor is measured with beside pictures: copying memory.
#pragma once

#include "present/headless.h"

#include <stdint.h>

/// Bytes a second that the device copies, from memory to memory: each is read and written. 0: it cannot be told.
double gl_measure_copy(const stp_headless* headless, uint64_t size);
