// SPDX-License-Identifier: MIT
#if defined(__x86_64__)

#include "lod/blue/growths_kernel.h"

const stp_growth_kernels stp_growth_kernels_avx2 = {cut, reach};

#endif
