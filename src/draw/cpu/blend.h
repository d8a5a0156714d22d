// SPDX-License-Identifier: MIT
//
// Splats that overlap blended with Gaussian-like weights (Botsch et al. 2005; Brandt 4.2): the visibility buffer says which
// surface a pixel shows, and all splats of that surface, each lit once, are added to it (raster/splats_blend.h).
#pragma once

#include "draw/cpu/cpu.h"

static inline bool cpu_has_filter(const stp_draw_style* style)
{
    return style->filter != STP_FILTER_NONE;
}

/// Notes which splat each pixel shows: between drawing and shading.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_find_visible(cpu_renderer* r);
/// Replaces the colours of splats' pixels: after shading. @return as cpu_draw_items
STP_MUST_USE stp_result cpu_blend_splats(cpu_renderer* r);
/// Replaces the depths of splats' pixels by those of their planes: after shading. @return as cpu_draw_items
STP_MUST_USE stp_result cpu_find_plane_depths(cpu_renderer* r);
/// What is done with a range of an item's splats in the stages of the filter.
void cpu_blend_range(const cpu_renderer* r, const cpu_item* item, const stp_raster_splats* splats);
void cpu_destroy_blend(cpu_renderer* r);
