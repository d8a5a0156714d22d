// SPDX-License-Identifier: MIT
// Morton curve kernels for AVX-512.
#if defined(__x86_64__)
#define KERNELS stp_curve_kernels_avx512
#include "order/curve_kernels.h"
#else
typedef int no_curve_here;
#endif
