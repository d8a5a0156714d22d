// SPDX-License-Identifier: MIT
// The loops of effects_rows.h for CPUs with AVX2.
#if defined(__x86_64__)

#include "draw/cpu/effects_rows.h"

const stp_cpu_effect_kernels stp_cpu_effect_kernels_avx2 = EFFECT_KERNELS;

#else

typedef int stp_cpu_effects_avx2_unused;

#endif
