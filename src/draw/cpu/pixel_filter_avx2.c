// SPDX-License-Identifier: MIT
// The loops of pixel_filter_rows.h for CPUs with AVX2.
#if defined(__x86_64__)

#include "draw/cpu/pixel_filter_rows.h"

const stp_cpu_pixel_kernels stp_cpu_pixel_kernels_avx2 = PIXEL_KERNELS;

#else

typedef int stp_cpu_pixel_filter_avx2_unused;

#endif
