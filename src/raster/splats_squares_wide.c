// SPDX-License-Identifier: MIT
// Square splats, auto-vectorised to 512 bits.
#include "raster/splats_squares_kernel.h"

uint64_t stp_splats_squares_wide(const stp_splat_frame* frame)
{
    return draw_all_squares(frame);
}
