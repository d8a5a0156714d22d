// SPDX-License-Identifier: MIT
//
// Alpha tests that keep their coverage in smaller mip levels (alpha-tested coverage, Castano 2010). Averaging pulls alpha
// towards its mean, so that with one cutoff for all levels a leaf shrinks or swells with distance. Here each level has its
// own threshold for each cutoff: the one with which the same share of the level is left as of level 0.
#pragma once

#include "raster/texture.h"

enum {
    STP_CUTOUT_STEPS = 256, ///< thresholds of a level: for cutoffs 0, 1/255, ..., 1
};

/// Makes pyramid->cutoffs, for use with any cutoff; nothing where they are there. They end with the last level that can keep
/// the shares: one that is grey all over has all texels or none. The wrap modes and the filter of the
/// pyramid must be set. The same on every compiler: samples are counted in whole numbers.
STP_MUST_USE stp_result stp_cutout_prepare(stp_context* context, stp_texture_pyramid* pyramid);

/// Whether a fragment of a cut-out is there.
/// @param own the alpha of the material and the vertices, which multiplies that of the texture
/// @param footprint the width of the pixel in texels of level 0
bool stp_cutout_keeps(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint, float own,
                      float cutoff);
