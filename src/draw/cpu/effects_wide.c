// SPDX-License-Identifier: MIT
// The loops of effects_rows.h for CPUs with AVX-512.
#include "draw/cpu/effects_rows.h"

const stp_cpu_effect_kernels stp_cpu_effect_kernels_wide = EFFECT_KERNELS;
