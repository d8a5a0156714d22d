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
#if defined(__x86_64__)
    switch (stp_processor_detect()) {
    case STP_PROCESSOR_AVX512:
        return stp_splats_blend_avx512;
    case STP_PROCESSOR_AVX2:
        return stp_splats_blend_avx2;
    case STP_PROCESSOR_BASELINE:
        break;
    }
#endif
    return stp_splats_blend_portable;
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
