// SPDX-License-Identifier: MIT
//
// Alpha tests that keep their coverage in smaller mip levels (alpha-tested coverage, Castano 2010).
// Averaging pulls alpha towards its mean, so with one cutoff for all levels a leaf shrinks or grows
// with distance. Here each level has its own threshold per cutoff, which keeps the same share of
// the level as of level 0.
#pragma once

#include "raster/texture.h"

enum {
    STP_CUTOUT_STEPS = 256, ///< thresholds per level: for cutoffs 0, 1/255, ..., 1
};

/// Makes pyramid->cutoffs, for any cutoff; does nothing if they exist. The last level with cutoffs
/// is the last that can keep the shares: a uniformly grey level keeps all texels or none. The
/// pyramid's wrap modes and filter must be set. Same results with every compiler: samples are
/// counted in integers.
STP_MUST_USE stp_result stp_cutout_prepare(stp_context* context, stp_texture_pyramid* pyramid);

/// Alpha test of a fragment.
/// @param own the alpha of the material and the vertices, which multiplies that of the texture
/// @param footprint the width of the pixel in texels of level 0
bool stp_cutout_keeps(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint, float own,
                      float cutoff);
