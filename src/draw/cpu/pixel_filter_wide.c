// SPDX-License-Identifier: MIT
// The loops of pixel_filter_rows.h for CPUs with AVX-512.
#include "draw/cpu/pixel_filter_rows.h"

const stp_cpu_pixel_kernels stp_cpu_pixel_kernels_wide = PIXEL_KERNELS;
