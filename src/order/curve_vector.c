// SPDX-License-Identifier: MIT
// Morton curve kernels for AVX2 or NEON.
#define KERNELS stp_curve_kernels_vector
#include "order/curve_kernels.h"
