// SPDX-License-Identifier: MIT
//
// Transparent surfaces of a picture, layer by layer. The opaque picture is drawn first. Then each pass draws transparent
// triangles and splats only, and of each pixel keeps the nearest that is behind the layer before and in front of what is
// opaque; shading lights it as any other surface, and it is composited in linear light, front to back. It ends where a pass
// finds nothing. Every step is a minimum or concerns one pixel alone: the picture does not depend on threads.
#pragma once

#include "base/coverage.h"
#include "draw/cpu/cpu.h"
#include "draw/cpu/shade.h"

/// Whether the picture that is drawn has layers; else transparent surfaces are drawn into it by thresholds.
bool cpu_wants_layers(const cpu_renderer* r, const stp_draw_style* style);

/// Room for them, before anything is drawn. Where memory does not suffice a warning is logged once, and the picture has none.
void cpu_begin_layers(cpu_renderer* r);
/// Before the opaque picture is shaded, which empties the buffers: remembers what is opaque.
void cpu_keep_opaque(cpu_renderer* r);
/// After that: draws all layers over the picture of the eye that is drawn, whose items are placed.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), or STP_ERROR_CANCELLED
STP_MUST_USE stp_result cpu_draw_layers(cpu_renderer* r);
void cpu_destroy_layers(cpu_renderer* r);

/// Composites a shaded tile of a layer.
void cpu_take_layer(cpu_renderer* r, cpu_worker* worker, const cpu_shade_tile* tile);

/// The share of a surfel's pixels that a stored coverage draws, of 255; disks that are cut count as whole.
static inline uint8_t cpu_coverage_share(const cpu_item* item, uint8_t coverage)
{
    return stp_coverage_share(item->surfels.plain_coverages ? stp_coverage_of_plain[coverage]
                                                            : coverage);
}

/// Leaves of splats (by their materials and coverages) those that are transparent, or those that are not: sets `wanted`, in the
/// worker's scratch memory, where there are both. @return how many are left; `failed` of the worker is set where memory runs out
uint32_t cpu_pick_glass(const cpu_renderer* r, const cpu_item* item, bool transparent,
                        stp_raster_splats* splats, cpu_worker* worker);
/// Draws the transparent ones of a range of surfels.
void cpu_draw_glass(const cpu_renderer* r, const cpu_item* item, const stp_raster_splats* splats,
                    const stp_raster_target* target, cpu_worker* worker);
