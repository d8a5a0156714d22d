// SPDX-License-Identifier: MIT
// The loops of effects_rows.h for CPUs with AVX-512.
#if defined(__x86_64__)

#include "draw/cpu/effects_rows.h"

const stp_cpu_effect_kernels stp_cpu_effect_kernels_avx512 = EFFECT_KERNELS;

#else

typedef int stp_cpu_effects_avx512_unused;

#endif
