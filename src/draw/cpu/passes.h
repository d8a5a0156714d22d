// SPDX-License-Identifier: MIT
// Steps of a picture on the CPU: its samples, their accumulation, blended splats, and caps.
#pragma once

#include "draw/cpu/cpu.h"

// Samples of a picture, each for all eyes, in one pass or two. With two passes, content occluded in
// the eyes' previous pictures is deferred; the pyramids are then rebuilt from the pictures so far,
// and deferred content that they do not occlude is drawn. One selection serves all eyes; each eye
// has its own pixels, pyramid and occlusion bits.

/// Selects the first pass of a two-pass sample, and measures the time. @return as stp_select
STP_MUST_USE stp_result stp_cpu_select_sample(stp_cpu_renderer* r);

/// Notes whether the list of the first sample, so far, is more work than wanted, and returns it.
bool stp_cpu_exceeds(stp_cpu_two_passes* passes);

/// Draws side * side samples of a picture without effects: shading sums them. @return result of the
/// first failing step
STP_MUST_USE stp_result stp_cpu_draw_summed(stp_cpu_renderer* r, const stp_draw_list* list,
                                            uint32_t side, stp_draw_stats* stats);
/// Draws samples [first, end) as separate pictures, added to the sum.
STP_MUST_USE stp_result stp_cpu_draw_accumulated(stp_cpu_renderer* r, const stp_draw_list* list,
                                                 uint32_t side, uint32_t first, uint32_t end,
                                                 stp_draw_stats* stats);
/// Puts the pictures of two eyes side by side.
void stp_cpu_join_eyes(stp_cpu_renderer* r, stp_image* image);

/// Clears all buffers after a failure.
void stp_cpu_empty_pixels(stp_cpu_renderer* r);

// A picture as the mean of frames, each shifted by a fraction of a pixel. Used for views at rest,
// and to combine supersampling with post-shading effects. Sums are integers, so they do not depend
// on the order of addition.

/// Drops the frames so far if they are of another view, list or style.
void stp_cpu_continue_accumulation(stp_cpu_renderer* r, const stp_view* view,
                                   const stp_draw_list* list, const stp_draw_style* style);

/// Allocates the sums; `frames` frames are already in them. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_make_accumulation(stp_cpu_renderer* r, uint32_t frames);
/// Adds the picture of the current eye to its sums of `frames` frames so far.
void stp_cpu_add_frame(stp_cpu_renderer* r);
/// Replaces that picture by the mean of all frames, at least one.
void stp_cpu_show_frames(stp_cpu_renderer* r);
void stp_cpu_destroy_accumulation(stp_cpu_renderer* r);

// Blends overlapping splats with Gaussian-like weights (Botsch et al. 2005; Brandt 4.2). The
// visibility buffer says which surface a pixel shows; all splats of that surface, each lit once,
// are added to it (raster/splats_blend.h).

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

// Caps of sections.

/// Whether the frame may have caps.
static inline bool stp_cpu_has_caps(const stp_cpu_renderer* r)
{
    return r->style->caps && r->sections->count > 0;
}

/// Draws caps (draw/caps.h) into the shaded picture and its depths. @return as stp_caps_find
STP_MUST_USE stp_result stp_cpu_put_caps(stp_cpu_renderer* r);
