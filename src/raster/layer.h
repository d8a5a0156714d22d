// SPDX-License-Identifier: MIT
//
// One layer of transparent surfaces (depth peeling, Everitt 2001): per pixel, the nearest fragment
// behind the previous layer and in front of the opaque surface. This is a minimum, so it does not
// depend on the drawing order.
#pragma once

#include "raster/target.h"

enum { STP_LAYER_MARKED = 64 }; ///< pixels, in their order in memory, that share a mark

typedef struct stp_raster_layer {
    const uint64_t* nearer;  ///< previous layer of each pixel; 0 for the first layer
    const uint64_t* farther; ///< opaque surface of each pixel
    /// Per pixel: splats at least this near belong to the surface of the previous layer. Disks of a
    /// surface overlap and count once.
    const float* splats_below;
    uint64_t* found; ///< counts the fragments between the two, drawn or not
    /// Per STP_LAYER_MARKED pixels: becomes true where there are such fragments
    bool* marks;
    /// The test of triangle fragments (`keep`) wants all of them between the two, nearest or not
    bool tests_all;
} stp_raster_layer;

/// Whether a triangle fragment lies between; `at` is the index of its pixel.
static inline bool stp_layer_has(const stp_raster_layer* layer, size_t at, uint64_t pixel)
{
    bool between = pixel > layer->nearer[at] && pixel < layer->farther[at];
    *layer->found += between;
    layer->marks[at / STP_LAYER_MARKED] |= between;
    return between;
}

/// Whether a splat fragment lies between.
static inline bool stp_layer_has_splat(const stp_raster_layer* layer, size_t at, uint64_t pixel)
{
    return stp_raster_nearness(pixel) < layer->splats_below[at] && stp_layer_has(layer, at, pixel);
}
