// SPDX-License-Identifier: MIT
// Grid search in plain C.
#include "order/vector_portable.h"

#define NEAREST stp_near_grid_nearest_portable
#include "order/near_grid_kernels.h"
