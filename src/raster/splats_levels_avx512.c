// SPDX-License-Identifier: MIT
// The test of ranges with 512-bit vectors, where the compiler makes them of its loops.
#include "raster/splats_levels_kernel.h"

bool stp_splats_pick_avx512(const levels_frame* frame, uint16_t* bits)
{
    return pick_all(frame, bits);
}
