// SPDX-License-Identifier: MIT
//
// A draw list becomes pixels. Every backend takes the same list and gives the same picture.
#pragma once

#include "raster/splat_texture.h"
#include "select/select.h"

#include <stipple/image.h>

#include <stdatomic.h>

/// The shape of splats without a filter.
typedef enum stp_splat_shape {
    STP_SPLAT_DISK,   ///< disks and ellipses in the surface, exactly as perspective shows them
    STP_SPLAT_SQUARE, ///< squares on the screen, as wide as the disks, at the depths of their centres
} stp_splat_shape;

typedef enum stp_filter {
    STP_FILTER_NONE, ///< a pixel shows one splat
    STP_FILTER_EWA, ///< splats of a pixel's surface are blended, weighted by how close their centres are
    STP_FILTER_BLEND, ///< the same in one pass: what is about as near as what was drawn before (OpenGL; else as EWA)
    STP_FILTER_TEXTURED, ///< as BLEND, weighted by the style's texture
} stp_filter;

/// How transparent surfaces are drawn.
typedef enum stp_transparency {
    STP_TRANSPARENCY_LAYERS, ///< sorted and composited: a picture without noise
    /// As a pattern of pixels that stays from frame to frame, in one pass: for motion, and where memory is short.
    STP_TRANSPARENCY_PATTERN,
} stp_transparency;

/// What colours pixels have.
typedef enum stp_draw_coloring {
    STP_DRAW_OWN_COLORS, ///< of what is drawn; a store may give others for points (store/coloring.h)
    STP_DRAW_ELEVATION,  ///< of their height in the scene
    STP_DRAW_NORMALS, ///< of the normal, red to the right, green up, blue to the front of the scene; without light
} stp_draw_coloring;

/// How large points are drawn, and splats that are original points.
typedef enum stp_point_sizing {
    STP_POINTS_ADAPTIVE, ///< as large as it takes to close the gaps between those that are drawn
    STP_POINTS_PIXELS,   ///< as disks on the screen, so many pixels wide
    STP_POINTS_UNITS,    ///< as disks that face the eye, so many units of the scene wide
} stp_point_sizing;

typedef struct stp_draw_style {
    float splat_scale;    ///< times the radius of every splat; default 1
    uint32_t supersample; ///< n x n samples a pixel; default 1
    bool
        headlight; ///< light from the eye; default: a directional light from above left of the viewer
    bool background; ///< fill with background_color, alpha 255; default: transparent black
    uint8_t background_color[3];
    stp_filter filter;
    stp_splat_shape splat_shape; ///< a filter draws disks always
    stp_point_sizing point_sizing;
    float point_size; ///< width of points of a fixed size; without splat_scale
    /// Weights of STP_FILTER_TEXTURED (raster/splat_texture.h); lives as long as the style. NULL: a Gaussian.
    const stp_splat_texture* splat_texture;
    float eye_dome;          ///< strength of eye-dome lighting; 0: none
    float ambient_occlusion; ///< reach of ambient occlusion, in heights of the picture; 0: none
    stp_transparency transparency;
    float ghost; ///< the part of a ghost's pixels that is drawn, above 0 to 1; 0: a fifth
    stp_draw_coloring coloring; ///< others than own colours: without a filter
    double elevation
        [2];   ///< of STP_DRAW_ELEVATION: heights (y) at the ends of the scale, the lower first
    bool caps; ///< closed solids that the view's sections cut are filled (draw/caps.h)
    /// Pixels that show a splat have the depth of its plane there, without the offset of its rim. CPU, without a filter.
    bool plane_depth;
} stp_draw_style;

typedef struct stp_draw_stats {
    double draw_ms, shade_ms;
    double select_ms; ///< of stp_renderer_draw_selected
    uint64_t splats, triangles, fragments, covered_pixels;
    uint32_t draw_calls; ///< items drawn
    uint32_t samples;    ///< of each pixel
    uint32_t layers;     ///< of transparent surfaces, the most in a pixel of the last sample
} stp_draw_stats;

typedef struct stp_renderer stp_renderer;

/// A renderer on the processor. Keeps decoded textures and scratch memory; a warm frame allocates nothing.
STP_MUST_USE stp_result stp_draw_cpu_create(stp_context* context, stp_store* store,
                                            stp_renderer** renderer);
void stp_renderer_destroy(stp_renderer* renderer);

/// Draws. `image` has the view's width and height; its pixels are the caller's. Of a view with two eyes, each has its half:
/// the views of select/eyes.h side by side. Figures are those of both.
STP_MUST_USE stp_result stp_renderer_draw(stp_renderer* renderer, const stp_view* view,
                                          const stp_draw_list* list, const stp_draw_style* style,
                                          stp_image* image, stp_draw_stats* stats);

/// Selects and draws in two passes: what the renderer's picture before hides is set aside, and what of that the new
/// picture does not hide is drawn after. `list` is filled; `quality->occlusion` is not looked at. The picture is that of
/// stp_select without occlusion and stp_renderer_draw, but for what lies at equal depths; only time depends on what was
/// drawn before. Each sample and each eye has two passes; a filter blends splats that are hidden too, so nothing is
/// set aside that it needs. Parallel pictures, those of a number of splats, of points of a fixed size, and those of
/// splats drawn larger than they were chosen are drawn in one pass.
/// @return as stp_select, stp_select_rejected and stp_renderer_draw
STP_MUST_USE stp_result stp_renderer_draw_selected(stp_renderer* renderer, const stp_view* view,
                                                   const stp_quality* quality,
                                                   const stp_draw_style* style, stp_draw_list* list,
                                                   stp_image* image, stp_draw_stats* stats);

/// Selects, and draws one more sample of a view that rests, a part of a pixel beside those before; the picture is the mean of
/// all samples since view, list or style last changed. There are style->supersample squared (from 2 x 2 on): then it is
/// what that draws at once but for rounding, and further calls draw nothing. A picture drawn otherwise in between may begin
/// the samples anew. `list` is filled; `quality->occlusion` is
/// not looked at. stats->samples says how many there are.
/// @return as stp_select and stp_renderer_draw
STP_MUST_USE stp_result stp_renderer_accumulate(stp_renderer* renderer, const stp_view* view,
                                                const stp_quality* quality,
                                                const stp_draw_style* style, stp_draw_list* list,
                                                stp_image* image, stp_draw_stats* stats);

/// From now on, drawing is abandoned soon after *stop becomes true (from any thread): it returns STP_ERROR_CANCELLED, which is not
/// logged, and the image is undefined. The next picture is the one that it would be without. `stop` belongs to the caller;
/// NULL: drawing is never abandoned. With a stop, OpenGL draws in portions and waits for each.
void stp_renderer_set_stop(stp_renderer* renderer, const atomic_bool* stop);

/// The nearness of each pixel of the last frame (0: background), one sample a pixel (of the last supersample),
/// `width * height` floats owned by the renderer, of two eyes one picture after the other; nearness = 1 / depth in perspective, times near_distance.
const float* stp_renderer_depth(const stp_renderer* renderer);
