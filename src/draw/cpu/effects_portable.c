// SPDX-License-Identifier: MIT
// The loops of effects_rows.h for any CPU.
#include "draw/cpu/effects_rows.h"

const stp_cpu_effect_kernels stp_cpu_effect_kernels_portable = EFFECT_KERNELS;
