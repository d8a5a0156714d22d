// SPDX-License-Identifier: MIT
//
// How alike two pictures are.
#pragma once

#include "base/context.h"

#include <stipple/image.h>

typedef struct stp_image_quality {
    double ssim;         ///< Wang et al. 2004: luminance, 11 x 11 Gaussian window, sigma 1.5, K1 .01, K2 .03
    double ssim_covered; ///< mean over pixels that either picture covers (alpha above 0); 1 where none does
    double ms_ssim;      ///< Wang et al. 2003: five scales
    double psnr;         ///< decibels over RGB; infinity for equal pictures
} stp_image_quality;

/// Compares pictures of one size. Both are composited on black first. `mask` (may be NULL; same size): only
/// pixels with alpha above 0 and a channel above 127 count for ssim_covered. `map` (may be NULL): receives the
/// SSIM of each pixel as grey.
/// @return STP_OK, STP_ERROR_ARGUMENT (sizes differ; logged), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_compare(stp_context* context, const stp_image* a, const stp_image* b,
                                          const stp_image* mask, stp_image* map, stp_image_quality* quality);
