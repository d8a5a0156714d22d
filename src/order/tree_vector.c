// SPDX-License-Identifier: MIT
// Tree kernels for AVX2 or NEON.
#include "order/vector.h"

#define KERNELS stp_tree_kernels_vector
#include "order/tree_kernels.h"
