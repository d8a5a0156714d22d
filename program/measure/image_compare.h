// SPDX-License-Identifier: MIT
//
// Image similarity metrics.
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

/// Replaces infinity, which JSON cannot express. Pictures that differ stay below 140.
#define STP_PSNR_EQUAL 200.0

/// A channel (0 to 2) of an RGBA pixel over black.
static inline int stp_composite_on_black(const uint8_t* pixel, int channel)
{
    return (pixel[channel] * pixel[3] + 127) / 255;
}

typedef struct stp_image_quality {
    /// Wang et al. 2004: luminance (Rec. 601 weights of the sRGB bytes), 11 x 11 Gaussian window,
    /// sigma 1.5, K1 .01, K2 .03. Mean over the pixels whose whole window lies inside the picture,
    /// as in the authors' program; over all pixels if the picture is smaller than 11 x 11.
    double ssim;
    /// Mean over pixels that either picture covers (alpha above 0); 1 if there are none. Windows
    /// are clipped at the border and their weights scaled to a sum of 1.
    double ssim_covered;
    /// Wang et al. 2003: five scales. Pictures below 161 pixels use the scales that fit a window,
    /// with weights scaled to a sum of 1. A negative mean counts as 0.
    double ms_ssim;
    double psnr; ///< decibels over RGB; STP_PSNR_EQUAL for equal pictures
} stp_image_quality;

/// Compares pictures of equal size, composited on black. `mask` (may be NULL; same size):
/// ssim_covered counts only covered pixels at which the mask has alpha above 0 and a channel above
/// 127. `map` (may be NULL): receives the SSIM of each pixel as grey, 0 if negative; its pixels
/// come from stp_alloc. The same bits for any number of threads.
/// @return STP_OK, STP_ERROR_ARGUMENT (sizes differ, or are 0; logged), STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_compare(stp_context* context, const stp_image* a,
                                          const stp_image* b, const stp_image* mask, stp_image* map,
                                          stp_image_quality* quality);

/// The truth of a picture (docs/measuring.md, Truth) as a share of that of all originals with one
/// sample a pixel. 1 if that is 0.
static inline double stp_truth_ratio(double truth, double exact)
{
    return exact > 0.0 ? truth / exact : 1.0;
}

// Structural similarity of two grey planes at one scale (Wang, Bovik, Sheikh, Simoncelli 2004,
// "Image quality assessment: from error visibility to structural similarity").
//   ssim = luminance * contrast_structure
//        = (2 ma mb + C1) / (ma^2 + mb^2 + C1)  *  (2 cov + C2) / (va + vb + C2)
// Means, variances and the covariance are weighted by an 11 x 11 Gaussian window of sigma 1.5. Each
// pixel has a value: at the border the window is clipped and its weights scaled to a sum of 1.

enum { STP_SSIM_RADIUS = 5 }; ///< pixels from the window's centre to its border

typedef struct stp_ssim_planes {
    uint32_t width, height;
    double peak;    ///< largest possible value
    const float* a; ///< width * height values
    const float* b;
    const uint8_t* counted; ///< not 0: the pixel counts towards `counted`; may be NULL
    uint8_t* map;           ///< receives RGBA, the value as grey; may be NULL
} stp_ssim_planes;

/// The first two are means over the pixels whose window lies inside the picture, as in the authors'
/// program; over all pixels if there are none (a picture smaller than 11 x 11).
typedef struct stp_ssim_means {
    double ssim, contrast_structure;
    double counted; ///< mean of ssim over the pixels that count; 1 if there are none
} stp_ssim_means;

/// The same bits for any number of threads. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_ssim(stp_context* context, const stp_ssim_planes* planes,
                                 stp_ssim_means* means);
