// SPDX-License-Identifier: MIT
// Morton curve kernels for AVX-512.
#define KERNELS stp_curve_kernels_wide
#include "order/curve_kernels.h"
