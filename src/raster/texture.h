// SPDX-License-Identifier: MIT
//
// Texture sampling: mip levels averaged in linear light, trilinear.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

enum { STP_TEXTURE_LEVELS = 16 };

typedef enum stp_texture_wrap {
    STP_TEXTURE_REPEAT,
    STP_TEXTURE_CLAMP,
    STP_TEXTURE_MIRROR
} stp_texture_wrap;

/// A picture with its mip levels. Level 0 is the caller's memory; the others are owned.
typedef struct stp_texture_pyramid {
    uint32_t level_count;
    uint32_t width[STP_TEXTURE_LEVELS], height[STP_TEXTURE_LEVELS];
    const uint8_t* texels[STP_TEXTURE_LEVELS]; ///< RGBA
    uint8_t* owned;
    stp_texture_wrap wrap_u, wrap_v;
    bool nearest;
    bool linear; ///< bytes are linear values, not sRGB
    /// NULL, or the thresholds that replace the alpha cutoff in each level (raster/cutout.h);
    /// owned.
    float* cutoffs;
    uint32_t cutoff_levels; ///< levels with thresholds; smaller ones are not tested
} stp_texture_pyramid;

/// Makes the levels. Colour is weighted by alpha, so that cutout borders do not bleed.
STP_MUST_USE stp_result stp_texture_pyramid_create(stp_context* context, const uint8_t* rgba,
                                                   uint32_t width, uint32_t height, bool linear,
                                                   stp_texture_pyramid* pyramid);
void stp_texture_pyramid_destroy(stp_context* context, stp_texture_pyramid* pyramid);

/// Samples at `uv` (0..1 is the picture, v down) with a footprint of `footprint` texels of level 0
/// (the longer side of the pixel's image in the texture). `out` is linear RGBA, 0..1.
void stp_texture_sample(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint,
                        float out[4]);

/// Samples alpha at level 0.
float stp_texture_sample_alpha(const stp_texture_pyramid* pyramid, stp_vec2 uv);
/// Samples alpha at a level, bilinearly; level 0 of a nearest-filtered texture uses the nearest
/// texel.
float stp_texture_sample_alpha_at(const stp_texture_pyramid* pyramid, stp_vec2 uv, uint32_t level);
/// Samples alpha at the level nearest to a footprint.
float stp_texture_sample_alpha_of(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint);
