// SPDX-License-Identifier: MIT
#include "base/core/processor.h"
#include "raster/splats_squares_kernel.h"

uint64_t stp_splats_squares_portable(const stp_splat_frame* frame)
{
    return draw_all_squares(frame);
}

uint64_t stp_splats_draw_squares(const stp_splat_frame* frame)
{
#if defined(__x86_64__)
    switch (stp_processor_detect()) {
    case STP_PROCESSOR_AVX512:
        return stp_splats_squares_avx512(frame);
    case STP_PROCESSOR_AVX2:
        return stp_splats_squares_avx2(frame);
    case STP_PROCESSOR_BASELINE:
        break;
    }
#endif
    return stp_splats_squares_portable(frame);
}
