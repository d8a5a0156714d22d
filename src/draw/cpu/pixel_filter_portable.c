// SPDX-License-Identifier: MIT
// The loops of pixel_filter_rows.h for any CPU.
#include "draw/cpu/pixel_filter_rows.h"

const stp_cpu_pixel_kernels stp_cpu_pixel_kernels_portable = PIXEL_KERNELS;
