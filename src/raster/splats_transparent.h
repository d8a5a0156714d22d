// SPDX-License-Identifier: MIT
//
// Splats of transparent surfaces. Their coverage is their opacity; they have no holes and keep
// their radius. They are drawn into a layer, or at pixels whose threshold is below their opacity.
// All splats of a set in one surface share the thresholds, so overlaps do not make them denser.
#pragma once

#include "raster/layer.h"
#include "raster/splats.h"

/// Rim depth and back depth in radii. Smaller than for opaque splats, so that a layer of splats is
/// thin.
#define STP_TRANSPARENT_RIM_DEPTH 1.0f
#define STP_TRANSPARENT_BACK_DEPTH 0.5f
/// How far behind the nearest disk of a surface its other disks may lie, in radii.
#define STP_TRANSPARENT_THICKNESS 3.0f
/// Size of a surface's cell (stp_blue_noise_key) in grid coordinates, as a power of two.
enum { STP_TRANSPARENT_CELL_SHIFT = 10 };

typedef struct stp_raster_transparency {
    const stp_raster_layer* layer; ///< NULL: use thresholds
    uint32_t seed, sample;         ///< seed (of the object) and sample of the thresholds
    float share;                   ///< factor on all opacities; below 1 for ghosts
} stp_raster_transparency;

/// Opacity of a surface of splats with this coverage (0 to 255), if on average two cover a pixel
/// (src/lod/blue/pyramid_chance.c chooses coverages this way).
static inline float stp_transparent_opacity(uint32_t coverage)
{
    float clear = 1.0f - (float)coverage * (1.0f / 255.0f);
    return 1.0f - clear * clear;
}

/// Draws the `wanted` splats; splat sets only. `splats` as for stp_raster_draw_splats, without
/// occluder and `hidden`.
/// @return fragments
uint64_t stp_raster_draw_transparent(const stp_raster_target* target,
                                     const stp_raster_camera* camera,
                                     const stp_raster_splats* splats, uint32_t first_id,
                                     const stp_raster_transparency* glass);
