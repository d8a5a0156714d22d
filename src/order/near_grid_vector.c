// SPDX-License-Identifier: MIT
// Grid search for AVX2 or NEON.
#include "order/vector.h"

#define NEAREST stp_near_grid_nearest_vector
#include "order/near_grid_kernels.h"
