// SPDX-License-Identifier: MIT
// Grid search for AVX2.
#if defined(__x86_64__)
#include "order/vector_avx2.h"

#define NEAREST stp_near_grid_nearest_avx2
#include "order/near_grid_kernels.h"
#else
typedef int no_search_here;
#endif
