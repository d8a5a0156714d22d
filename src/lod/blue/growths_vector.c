// SPDX-License-Identifier: MIT
#include "lod/blue/growths_kernel.h"

const stp_growth_kernels stp_growth_kernels_vector = {cut, reach};
