// SPDX-License-Identifier: MIT
//
// Structural similarity of two grey planes at one scale (Wang, Bovik, Sheikh, Simoncelli 2004,
// "Image quality assessment: from error visibility to structural similarity").
//
//   ssim = luminance * contrast_structure
//        = (2 ma mb + C1) / (ma^2 + mb^2 + C1)  *  (2 cov + C2) / (va + vb + C2)
//
// Means, variances and the covariance are weighted by an 11 x 11 Gaussian window of sigma 1.5. Each
// pixel has a value: at the border the window is clipped and its weights scaled to a sum of 1.
#pragma once

#include "base/core/context.h"

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
