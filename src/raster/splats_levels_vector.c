// SPDX-License-Identifier: MIT
// The level range test, auto-vectorised to 256 bits, or NEON's 128.
#include "raster/splats_levels_kernel.h"

bool stp_splats_pick_vector(const levels_frame* frame, uint16_t* bits)
{
    return pick_all(frame, bits);
}
