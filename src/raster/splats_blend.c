// SPDX-License-Identifier: MIT
#include "raster/splats_blend.h"

#include "base/core/processor.h"
#include "raster/splats_blend_kernel.h"

void stp_splats_blend_portable(const stp_raster_blend* blend, const stp_raster_camera* camera,
                               const stp_raster_splats* splats, bool adds)
{
    blend_all(blend, camera, splats, adds);
}

static blend_kernel choose_kernel(void)
{
    return STP_VARIANT(stp_processor_detect(), stp_splats_blend);
}

void stp_raster_find_planes(const stp_raster_blend* blend, const stp_raster_camera* camera,
                            const stp_raster_splats* splats)
{
    choose_kernel()(blend, camera, splats, false);
}

void stp_raster_blend_splats(const stp_raster_blend* blend, const stp_raster_camera* camera,
                             const stp_raster_splats* splats)
{
    choose_kernel()(blend, camera, splats, true);
}
