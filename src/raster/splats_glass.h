// SPDX-License-Identifier: MIT
//
// Splats of transparent surfaces. Their coverage says how opaque they are, and they have no holes and keep their radius. They
// are drawn into a layer, or where a threshold of the pixel is below their opacity. All splats of a set that lie in one
// surface share the thresholds, so that overlapping does not make them denser.
#pragma once

#include "raster/layer.h"
#include "raster/splats.h"

/// In radii: how far rims fall behind their planes, and disks seen from behind; less than those of opaque splats, so that a
/// layer of splats is thin.
#define STP_GLASS_RIM_DEPTH 1.0f
#define STP_GLASS_BACK_DEPTH 0.5f
/// In radii: how far behind the nearest disk of a surface its other disks may lie.
#define STP_GLASS_THICKNESS 3.0f
/// Grid numbers of a surface's cell (stp_blue_noise_key), as a power of two.
enum { STP_GLASS_CELL_SHIFT = 10 };

typedef struct stp_raster_glass {
    const stp_raster_layer* layer; ///< NULL: by thresholds
    uint32_t seed, sample;         ///< of the thresholds
    float share;                   ///< times all opacities; 1, or that of a ghost
} stp_raster_glass;

/// The opacity of a surface of splats of this coverage (0 to 255), two of which cover a pixel on the mean
/// (src/lod/blue/pyramid_chance.c chooses coverages so).
static inline float stp_glass_opacity(uint32_t coverage)
{
    float clear = 1.0f - (float)coverage * (1.0f / 255.0f);
    return 1.0f - clear * clear;
}

/// Draws those of the splats that are `wanted`: surfels. `splats` as for stp_raster_draw_splats, without occluder and `hidden`.
/// @return fragments
uint64_t stp_raster_draw_glass(const stp_raster_target* target, const stp_raster_camera* camera,
                               const stp_raster_splats* splats, uint32_t first_id,
                               const stp_raster_glass* glass);
