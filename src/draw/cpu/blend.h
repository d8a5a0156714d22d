// SPDX-License-Identifier: MIT
//
// Blends overlapping splats with Gaussian-like weights (Botsch et al. 2005; Brandt 4.2). The
// visibility buffer says which surface a pixel shows; all splats of that surface, each lit once,
// are added to it (raster/splats_blend.h).
#pragma once

#include "draw/cpu/cpu.h"

static inline bool stp_cpu_has_filter(const stp_draw_style* style)
{
    return style->filter != STP_FILTER_NONE;
}

/// Records which splat each pixel shows. Call between drawing and shading.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), or STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_cpu_find_visible(stp_cpu_renderer* r);
/// Replaces the colours of splat pixels. Call after shading. @return as stp_cpu_draw_items
STP_MUST_USE stp_result stp_cpu_blend_splats(stp_cpu_renderer* r);
/// Replaces the depths of splat pixels by those of their planes. Call after shading. @return as
/// stp_cpu_draw_items
STP_MUST_USE stp_result stp_cpu_find_plane_depths(stp_cpu_renderer* r);
/// Processes a range of an item's splats in a stage of the filter.
void stp_cpu_blend_range(const stp_cpu_renderer* r, const stp_cpu_item* item,
                         const stp_raster_splats* splats);
void stp_cpu_destroy_blend(stp_cpu_renderer* r);
