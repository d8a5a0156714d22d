// SPDX-License-Identifier: MIT
//
// How alike two pictures are.
#pragma once

#include "base/context.h"

#include <stipple/image.h>

/// Stands for infinity, which JSON has no word for. Pictures that differ stay below 140.
#define STP_PSNR_EQUAL 200.0

typedef struct stp_image_quality {
    /// Wang et al. 2004: luminance (Rec. 601 weights of the sRGB bytes), 11 x 11 Gaussian window,
    /// sigma 1.5, K1 .01, K2 .03. Mean over the pixels whose whole window lies within the picture,
    /// as the authors' program has it; over all pixels in a picture of less than 11 x 11.
    double ssim;
    /// Mean over pixels that either picture covers (alpha above 0); 1 where none does. Windows that
    /// reach over the border are cut and their weights scaled to a sum of 1.
    double ssim_covered;
    /// Wang et al. 2003: five scales; as many as have room for a window in a picture of less than
    /// 161 pixels, their weights scaled to a sum of 1. A negative mean counts as 0.
    double ms_ssim;
    double psnr; ///< decibels over RGB; STP_PSNR_EQUAL for equal pictures
} stp_image_quality;

/// Compares pictures of one size. Both are composited on black first. `mask` (may be NULL; same
/// size): only covered pixels where it has an alpha above 0 and a channel above 127 count for
/// ssim_covered. `map` (may be NULL): receives the SSIM of each pixel as grey, 0 where it is
/// negative; its pixels come from stp_alloc. The same bits for any number of threads.
/// @return STP_OK, STP_ERROR_ARGUMENT (sizes differ; logged), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_compare(stp_context* context, const stp_image* a,
                                          const stp_image* b, const stp_image* mask, stp_image* map,
                                          stp_image_quality* quality);
