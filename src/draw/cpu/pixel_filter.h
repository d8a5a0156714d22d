// SPDX-License-Identifier: MIT
//
// The pixel filter: a finished picture with one sample a pixel becomes one in which each pixel is a
// mean of itself and its eight neighbours, with weights (k, 1 - 2k, k) across and down, in light
// and premultiplied by coverage. What aliases spreads over the pixels that see the same parts.
// Splats stand for more surface than a pixel's centre hits, so pixels that show one have a larger k
// than those of triangles and of the background. Open pixels, and covered ones, stay exactly as they
// are among equal neighbours; others to within a level.
#pragma once

#include "draw/cpu/cpu.h"

/// Loops over one row. Light is a byte squared, which is near enough to sRGB's curve; coverage is
/// alpha times 255. So all lie between 0 and 65025. Weights are 2k in 65536ths.
typedef struct stp_cpu_pixel_kernels {
    /// Light of `width` pixels, whose alpha is 0 or 255, times coverage.
    void (*light)(const uint8_t* pixels, uint16_t* light, uint32_t width);
    /// Weights of the four channels of each pixel, from its kind: 1 where it shows a splat.
    void (*weigh)(const uint8_t* kinds, uint16_t* weights, uint32_t width);
    /// The mean across. Reads `light` from one pixel before to one behind the row.
    void (*across)(const uint16_t* light, const uint16_t* weights, uint16_t* out, uint32_t width);
    /// The mean of three rows, as pixels. `light` is scratch, four numbers a pixel.
    void (*down)(const uint16_t* const rows[3], const uint16_t* weights, uint16_t* light,
                 uint8_t* pixels, uint32_t width);
} stp_cpu_pixel_kernels;

extern const stp_cpu_pixel_kernels stp_cpu_pixel_kernels_portable, stp_cpu_pixel_kernels_vector,
    stp_cpu_pixel_kernels_wide;
const stp_cpu_pixel_kernels* stp_cpu_choose_pixel_kernels(void);

/// Whether the frame's pictures are filtered: those with one sample, if the style wants it.
static inline bool stp_cpu_filters_pixels(const stp_cpu_renderer* r)
{
    return r->style->pixel_filter && r->sample_count == 1;
}

/// Allocates memory for the current picture. Shading then records what each pixel shows.
/// @return whether the picture is filtered; false if there is no memory for it: warns once
bool stp_cpu_begin_pixel_filter(stp_cpu_renderer* r);
/// Filters the current eye's finished picture.
void stp_cpu_filter_pixels(stp_cpu_renderer* r);
void stp_cpu_destroy_pixel_filter(stp_cpu_renderer* r);
