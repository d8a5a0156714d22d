// SPDX-License-Identifier: MIT
//
// Order-independent transparency by depth peeling. The opaque picture is drawn first. Then each
// pass draws transparent triangles and splats only. Per pixel it keeps the nearest fragment behind
// the previous layer and in front of the opaque surface; the fragment is shaded like any other
// surface and composited in linear light, front to back. Peeling ends with a pass that finds
// nothing. With STP_TRANSPARENCY_NEAREST, there is one pass: it also sums up the optical depths of
// all triangles before the opaque surface, and its layer gets their opacity. (Of splats, the
// nearest counts: how many overlap differs from pixel to pixel.) Every step is a
// minimum, a sum of integers or affects a single pixel: the picture does not depend on threads.
#pragma once

#include "base/splats/coverage.h"
#include "draw/cpu/cpu.h"
#include "draw/cpu/shade.h"

/// Whether the current picture has layers; otherwise transparent surfaces are drawn by alpha
/// thresholds.
bool stp_cpu_wants_layers(const stp_cpu_renderer* r, const stp_draw_style* style);

/// Allocates layers, before anything is drawn. Without enough memory, logs a warning once and draws
/// no layers.
void stp_cpu_begin_layers(stp_cpu_renderer* r);
/// Call after shading the opaque picture, which saves its visibility: draws all layers over the
/// picture of the current eye, whose items are placed.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), or STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_cpu_draw_layers(stp_cpu_renderer* r);
void stp_cpu_destroy_layers(stp_cpu_renderer* r);

/// Whether the current layer has fragments in a tile; in others, all buffers are empty.
bool stp_cpu_has_layer(const stp_cpu_renderer* r, const stp_cpu_shade_tile* tile);
/// Composites a shaded tile of a layer.
void stp_cpu_take_layer(stp_cpu_renderer* r, stp_cpu_worker* worker,
                        const stp_cpu_shade_tile* tile);

/// Share of a splat's pixels drawn by a stored coverage, of 255; clipped disks count as whole.
static inline uint8_t stp_cpu_coverage_share(const stp_cpu_item* item, uint8_t coverage)
{
    return stp_coverage_share(item->splats.plain_coverages ? stp_coverage_of_plain[coverage]
                                                           : coverage);
}

/// Filters splats by material and coverage: keeps the transparent ones, or the opaque ones. Sets
/// `wanted`, in the worker's scratch memory, if there are both. @return number of kept splats; sets
/// the worker's `failed` if out of memory
uint32_t stp_cpu_pick_transparent(const stp_cpu_renderer* r, const stp_cpu_item* item,
                                  bool transparent, stp_raster_splats* splats,
                                  stp_cpu_worker* worker);
/// Draws the transparent splats of a range.
void stp_cpu_draw_transparent(const stp_cpu_renderer* r, const stp_cpu_item* item,
                              const stp_raster_splats* splats, const stp_raster_target* target,
                              stp_cpu_worker* worker);
