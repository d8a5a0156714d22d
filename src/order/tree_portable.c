// SPDX-License-Identifier: MIT
// Tree kernels in plain C.
#include "order/vector_portable.h"

#define KERNELS stp_tree_kernels_portable
#include "order/tree_kernels.h"
