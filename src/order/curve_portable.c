// SPDX-License-Identifier: MIT
// Morton curve kernels in plain C.
#define KERNELS stp_curve_kernels_portable
#include "order/curve_kernels.h"
