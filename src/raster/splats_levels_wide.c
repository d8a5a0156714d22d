// SPDX-License-Identifier: MIT
// The level range test, auto-vectorised to 512 bits.
#include "raster/splats_levels_kernel.h"

bool stp_splats_pick_wide(const levels_frame* frame, uint16_t* bits)
{
    return pick_all(frame, bits);
}
