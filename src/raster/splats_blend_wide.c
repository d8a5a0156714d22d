// SPDX-License-Identifier: MIT
// The splat filter, auto-vectorised to 512 bits.
#include "raster/splats_blend_kernel.h"

void stp_splats_blend_wide(const stp_raster_blend* blend, const stp_raster_camera* camera,
                           const stp_raster_splats* splats, bool adds)
{
    blend_all(blend, camera, splats, adds);
}
