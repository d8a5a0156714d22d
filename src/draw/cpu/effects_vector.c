// SPDX-License-Identifier: MIT
// The loops of effects_rows.h for vectors of 32 bytes, or NEON's.
#include "draw/cpu/effects_rows.h"

const stp_cpu_effect_kernels stp_cpu_effect_kernels_vector = EFFECT_KERNELS;
