// SPDX-License-Identifier: MIT
//
// Post-shading effects: eye-dome lighting (Boucheny 2009) and ambient occlusion. Both read only
// pixel nearness, row by row, at the same offsets for all pixels. So the loops vectorize
// (effects_rows.h), there is no noise, and threads divide the rows. A small blur smooths occlusion.
//
// A nearness difference times a pixel's gain is a depth difference in pixel sides at that depth.
// Planes are linear in nearness in both projections: opposite neighbours on a plane cancel out, at
// any slope.
#pragma once

#include "draw/cpu/cpu.h"
#include "draw/effect_shape.h"

enum {
    EFFECT_BAND_ROWS = 8,
    /// Level of the depth pyramid that stands for the surroundings, and the side of its blocks
    STP_EFFECT_LEVEL = 1,
    STP_EFFECT_BLOCK = STP_DEPTH_PYRAMID_BLOCK << STP_EFFECT_LEVEL,
};

/// Loops over the pixels of a row. All arithmetic is single IEEE operations: all variants give the
/// same bits.
typedef struct stp_cpu_effect_kernels {
    /// Maximum (minimum) of values at offsets -reach .. reach.
    void (*greatest)(const float* in, int32_t reach, float* out, uint32_t count);
    void (*minimum)(const float* in, int32_t reach, float* out, uint32_t count);
    void (*add_max)(const float* in, float* out, uint32_t count);
    void (*add_min)(const float* in, float* out, uint32_t count);
    /// Gains: scale / nearness, or `scale` if constant; 0 for background.
    void (*gain)(const float* nearness, float scale, bool constant, float* out, uint32_t count);
    /// Adds the slopes by which opposite neighbours rise above each pixel.
    void (*rise)(const float* center, const float* gain, const float* const neighbours[2],
                 float inverse, float* sum, uint32_t count);
    /// Turns sums of rises into factors.
    void (*eye_dome)(float* sum, float strength, uint32_t count);
    /// Adds the combined rise of two opposite neighbours above each pixel.
    void (*pair)(const float* center, const float* gain, const float* const neighbours[2],
                 const float numbers[3], float* sum, uint32_t count);
    /// Adds neighbours at similar depths to sums and weights.
    void (*blur)(const float* center, const float* gain, const float* neighbour,
                 const float* values, float inverse, float* const sums[2], uint32_t count);
    /// Interpolates between two rows of blocks, then along them.
    void (*spread)(const float* const rows[2], float share, float* mixed, uint32_t columns,
                   float* out, uint32_t count);
} stp_cpu_effect_kernels;

extern const stp_cpu_effect_kernels stp_cpu_effect_kernels_portable, stp_cpu_effect_kernels_vector,
    stp_cpu_effect_kernels_wide;
const stp_cpu_effect_kernels* stp_cpu_choose_effect_kernels(void);

static inline bool stp_cpu_has_effects(const stp_draw_style* style)
{
    return style->eye_dome > 0.0f || style->ambient_occlusion > 0.0f;
}

/// Darkens the frame's picture. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_apply_effects(stp_cpu_renderer* r);
void stp_cpu_destroy_effects(stp_cpu_renderer* r);
