// SPDX-License-Identifier: MIT
// Tree kernels for AVX-512.
#include "order/vector_avx512.h"

#define KERNELS stp_tree_kernels_wide
#include "order/tree_kernels.h"
