// SPDX-License-Identifier: MIT
//
// Opacity texture for blended splats. It covers the bounding rectangle of a splat's disk or ellipse
// in the splat's plane and is sampled bilinearly. The opacity is the weight of the splat's colour
// (Dachsbacher et al. 2003, section 5).
#pragma once

#include <stipple/image.h>

enum { STP_SPLAT_TEXTURE_SIDE = 32 };

typedef struct stp_splat_texture {
    uint8_t texels[STP_SPLAT_TEXTURE_SIDE * STP_SPLAT_TEXTURE_SIDE]; ///< rows along the larger axis
} stp_splat_texture;

/// exp(-2 r^2), r = 1 at the rim.
stp_splat_texture stp_splat_texture_gaussian(void);

/// Averages an image's alpha, or its luma if the image is opaque. The image must have pixels.
stp_splat_texture stp_splat_texture_of_image(const stp_image* image);

/// Mean opacity within the disk, 0 to 1: the weight of a one-pixel splat.
float stp_splat_texture_mean(const stp_splat_texture* texture);

/// Opacity at (x, y), 0 to 1. Coordinates are clamped to -1 to 1.
static inline float stp_splat_texture_read(const stp_splat_texture* texture, float x, float y)
{
    const float side = (float)STP_SPLAT_TEXTURE_SIDE, last = side - 1.0f;
    float s = (0.5f * x + 0.5f) * side - 0.5f, t = (0.5f * y + 0.5f) * side - 0.5f;
    s = s > 0.0f ? s : 0.0f; // also for NaN
    t = t > 0.0f ? t : 0.0f;
    s = s < last ? s : last;
    t = t < last ? t : last;
    int left = (int)s, top = (int)t;
    int right = left + (left + 1 < STP_SPLAT_TEXTURE_SIDE);
    int bottom = top + (top + 1 < STP_SPLAT_TEXTURE_SIDE);
    float across = s - (float)left, down = t - (float)top;
    const uint8_t* upper = texture->texels + top * STP_SPLAT_TEXTURE_SIDE;
    const uint8_t* lower = texture->texels + bottom * STP_SPLAT_TEXTURE_SIDE;
    float a = (float)upper[left] + across * ((float)upper[right] - (float)upper[left]);
    float b = (float)lower[left] + across * ((float)lower[right] - (float)lower[left]);
    return (a + down * (b - a)) * (1.0f / 255.0f);
}
