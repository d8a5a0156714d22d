// SPDX-License-Identifier: MIT
#include "lod/point_normals_kernel.h"

const stp_normal_kernels stp_normal_kernels_vector = {sum_near, project};
