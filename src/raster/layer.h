// SPDX-License-Identifier: MIT
//
// One layer of transparent surfaces (depth peeling, Everitt 2001): of the fragments behind the layer before and in front of what
// is opaque, the nearest of each pixel. It is a minimum again, so it does not depend on the order of drawing.
#pragma once

#include "raster/target.h"

typedef struct stp_raster_layer {
    const uint64_t* nearer;  ///< of each pixel, the layer before; 0 at first
    const uint64_t* farther; ///< of each pixel, what is opaque
    /// Of each pixel: splats that are at least so near belong to the surface of the layer before. Disks of a surface overlap,
    /// and count once.
    const float* splats_below;
    uint64_t* found; ///< the fragments between the two are added, drawn or not
} stp_raster_layer;

/// Whether a fragment of a triangle lies between; `at` is the place of its pixel.
static inline bool stp_layer_has(const stp_raster_layer* layer, size_t at, uint64_t pixel)
{
    bool between = pixel > layer->nearer[at] && pixel < layer->farther[at];
    *layer->found += between;
    return between;
}

/// The same of a splat.
static inline bool stp_layer_has_splat(const stp_raster_layer* layer, size_t at, uint64_t pixel)
{
    return stp_raster_nearness(pixel) < layer->splats_below[at] && stp_layer_has(layer, at, pixel);
}
