// SPDX-License-Identifier: MIT
#include "base/core/processor.h"
#include "raster/splats_levels_kernel.h"

#include <assert.h>

bool stp_splats_pick_portable(const levels_frame* frame, uint16_t* bits)
{
    return pick_all(frame, bits);
}

bool stp_raster_pick_levels(const stp_raster_camera* camera, const stp_raster_splats* splats,
                            const uint32_t* ranges, const stp_raster_levels* levels, uint16_t* bits)
{
    assert(splats->begin <= splats->end && splats->begin % SPLAT_BATCH == 0);
    assert((!levels->beside_triangles || levels->groups != NULL) && "groups hold the marks");
    levels_frame frame = {.splats = splats, .ranges = ranges, .levels = *levels};
    stp_splats_fold_row(camera->matrix.m[3], splats, frame.w);
    if (levels->groups != NULL) {
        const stp_raster_frame picture = {
            .width = levels->width, .height = levels->height, .one_sided = levels->one_sided};
        frame.groups = stp_raster_groups_make(camera, splats, &picture);
    }
#if defined(__x86_64__)
    switch (stp_processor_detect()) {
    case STP_PROCESSOR_AVX512:
        return stp_splats_pick_avx512(&frame, bits);
    case STP_PROCESSOR_AVX2:
        return stp_splats_pick_avx2(&frame, bits);
    case STP_PROCESSOR_BASELINE:
        break;
    }
#endif
    return stp_splats_pick_portable(&frame, bits);
}
