// SPDX-License-Identifier: MIT
// Square splats with 256-bit vectors, where the compiler makes them of its loops.
#include "raster/splats_squares_kernel.h"

uint64_t stp_splats_squares_avx2(const stp_splat_frame* frame)
{
    return draw_all_squares(frame);
}
