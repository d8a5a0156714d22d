// SPDX-License-Identifier: MIT
// The curve's kernels, in plain C.
#define KERNELS stp_curve_kernels_portable
#include "order/curve_kernels.h"
