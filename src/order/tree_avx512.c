// SPDX-License-Identifier: MIT
// Tree kernels for AVX-512.
#if defined(__x86_64__)
#include "order/vector_avx512.h"

#define KERNELS stp_tree_kernels_avx512
#include "order/tree_kernels.h"
#else
typedef int no_kernels_here;
#endif
