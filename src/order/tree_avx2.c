// SPDX-License-Identifier: MIT
// Tree kernels for AVX2.
#if defined(__x86_64__)
#include "order/vector_avx2.h"

#define KERNELS stp_tree_kernels_avx2
#include "order/tree_kernels.h"
#else
typedef int no_kernels_here;
#endif
