// SPDX-License-Identifier: MIT
// The loops of pixel_filter_rows.h for vectors of 32 bytes, or NEON's.
#include "draw/cpu/pixel_filter_rows.h"

const stp_cpu_pixel_kernels stp_cpu_pixel_kernels_vector = PIXEL_KERNELS;
