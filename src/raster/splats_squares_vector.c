// SPDX-License-Identifier: MIT
// Square splats, auto-vectorised to 256 bits, or NEON's 128.
#include "raster/splats_squares_kernel.h"

uint64_t stp_splats_squares_vector(const stp_splat_frame* frame)
{
    return draw_all_squares(frame);
}
