// SPDX-License-Identifier: MIT
#if defined(__x86_64__)

#include "lod/point_normals_kernel.h"

const stp_normal_kernels stp_normal_kernels_avx2 = {sum_near, project};

#endif
