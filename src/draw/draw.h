// SPDX-License-Identifier: MIT
//
// Draws a draw list into pixels. All backends take the same lists and give the same pictures.
#pragma once

#include "raster/splat_texture.h"
#include "select/select.h"

#include <stipple/image.h>

#include <stdatomic.h>

/// The shape of splats without a filter.
typedef enum stp_splat_shape {
    STP_SPLAT_DISK, ///< disks and ellipses in the surface, in exact perspective
    /// screen-aligned squares, as wide as the disks, at the depths of their centres
    STP_SPLAT_SQUARE,
} stp_splat_shape;

typedef enum stp_filter {
    STP_FILTER_NONE, ///< a pixel shows one splat
    /// Splats of a pixel's surface are blended, weighted by the distance of their centres
    STP_FILTER_EWA,
    /// The same in one pass: blends fragments of similar depth (OpenGL; other backends use EWA)
    STP_FILTER_BLEND,
    STP_FILTER_TEXTURED, ///< like BLEND, weighted by the style's texture
} stp_filter;

/// Drawing of transparent surfaces.
typedef enum stp_transparency {
    STP_TRANSPARENCY_LAYERS, ///< sorted and composited: a picture without noise
    /// Screen-door pattern that is stable between frames, in one pass: if memory is short.
    STP_TRANSPARENCY_PATTERN,
    /// The nearest layer over the opaque surface, as opaque as all layers together: for motion. A
    /// picture without noise, which takes one pass over the transparent surfaces.
    STP_TRANSPARENCY_NEAREST,
} stp_transparency;

/// Colouring of pixels.
typedef enum stp_draw_coloring {
    /// Surface colours; a store may override those of points (store/file/point_attributes.h)
    STP_DRAW_OWN_COLORS,
    STP_DRAW_ELEVATION, ///< by height in the scene
    /// By normal, red to the right, green up, blue to the front of the scene; unlit
    STP_DRAW_NORMALS,
} stp_draw_coloring;

/// Size of points, and of splats that are original points.
typedef enum stp_point_sizing {
    STP_POINTS_ADAPTIVE, ///< large enough to close gaps between the drawn points
    STP_POINTS_PIXELS,   ///< screen-aligned disks, width in pixels
    STP_POINTS_UNITS,    ///< disks that face the eye, width in scene units
} stp_point_sizing;

typedef struct stp_draw_style {
    float splat_scale;    ///< factor on all splat radii; default 1
    uint32_t supersample; ///< n x n samples per pixel; default 1
    /// Light from the eye; default: a directional light from above left of the viewer
    bool headlight;
    bool background; ///< fill with background_color, alpha 255; default: transparent black
    uint8_t background_color[3];
    stp_filter filter;
    stp_splat_shape splat_shape; ///< filters always draw disks
    stp_point_sizing point_sizing;
    float point_size; ///< width of fixed-size points; independent of splat_scale
    /// Weights of STP_FILTER_TEXTURED (raster/splat_texture.h); lives as long as the style. NULL: a
    /// Gaussian.
    const stp_splat_texture* splat_texture;
    float eye_dome; ///< strength of eye-dome lighting; 0: none
    /// Radius of ambient occlusion, relative to the picture's height; 0: none
    float ambient_occlusion;
    stp_transparency transparency;
    float ghost; ///< share of a ghost's pixels that is drawn, above 0 to 1; 0: a fifth
    stp_draw_coloring coloring; ///< modes other than own colours: without a filter
    /// For STP_DRAW_ELEVATION: heights (y) at the ends of the scale, the lower first
    double elevation[2];
    /// Backs of single-sided materials (STP_SHADING_FRONT_ONLY) are drawn, too. They are also while
    /// the view has sections: a cut solid shows its inside.
    bool back_faces;
    /// Pictures with one sample a pixel pass the pixel filter, which calms what aliases. Pictures of
    /// several samples do not need it.
    bool pixel_filter;
    bool caps; ///< fills closed solids that the view's sections cut (draw/caps.h)
    /// Pixels that show a splat have the depth of its plane there, without the offset of its rim:
    /// for `stipple-lab bench quality`, which compares depths. CPU, without a filter.
    bool plane_depth;
    /// Effects that a budget left out of the style (draw/frame_effects.h). Pictures do not depend on
    /// it.
    uint32_t left_out;
    /// Share of the picture's width and height that stp_renderer_draw_selected draws, and enlarges to
    /// its size; 0 and from 1 on: all
    float resolution;
} stp_draw_style;

/// Share of a picture's width and height that a style draws; 1: all.
static inline float stp_draw_resolution(const stp_draw_style* style)
{
    return style->resolution > 0.0f && style->resolution < 1.0f ? style->resolution : 1.0f;
}

/// Whether two styles give the same picture.
static inline bool stp_draw_style_is_same(const stp_draw_style* a, const stp_draw_style* b)
{
    return a->splat_scale == b->splat_scale && a->supersample == b->supersample &&
           a->headlight == b->headlight && a->background == b->background &&
           a->background_color[0] == b->background_color[0] &&
           a->background_color[1] == b->background_color[1] &&
           a->background_color[2] == b->background_color[2] && a->filter == b->filter &&
           a->splat_shape == b->splat_shape && a->point_sizing == b->point_sizing &&
           a->point_size == b->point_size && a->splat_texture == b->splat_texture &&
           a->eye_dome == b->eye_dome && a->ambient_occlusion == b->ambient_occlusion &&
           a->transparency == b->transparency && a->ghost == b->ghost &&
           a->coloring == b->coloring && a->elevation[0] == b->elevation[0] &&
           a->elevation[1] == b->elevation[1] && a->caps == b->caps &&
           a->back_faces == b->back_faces && a->pixel_filter == b->pixel_filter &&
           a->plane_depth == b->plane_depth && stp_draw_resolution(a) == stp_draw_resolution(b);
}

typedef struct stp_draw_stats {
    double draw_ms, shade_ms;
    double select_ms; ///< time of selection, if the call selects
    /// Parts of shade_ms: eye-dome lighting and ambient occlusion, and layers of transparent
    /// surfaces
    double effect_ms, layer_ms;
    /// Drawn: splats of the wanted level in the picture, triangles of clusters in view; on the CPU
    /// without those that the occlusion test hides. Mean of the samples, sum of the eyes. OpenGL
    /// counts splats of a picture that stays on the GPU as listed until stp_draw_gl_finish_stats
    uint64_t splats, triangles;
    uint64_t listed_splats, listed_triangles; ///< of the list: what was looked at
    uint64_t fragments, covered_pixels;
    uint32_t draw_calls; ///< CPU: items drawn, for all eyes; OpenGL: draw calls of the last sample
    uint32_t samples;    ///< number of samples per pixel
    uint32_t layers;     ///< layers of transparent surfaces: maximum in a pixel of the last sample
    /// The list exceeds stp_quality.limit: the picture was given up, and is as before; the
    /// renderer's depths are not. CPU only
    bool exceeds;
} stp_draw_stats;

typedef struct stp_renderer stp_renderer;

/// A CPU renderer. Keeps decoded textures and scratch memory; a warm frame allocates nothing.
STP_MUST_USE stp_result stp_draw_cpu_create(stp_context* context, stp_store* store,
                                            stp_renderer** renderer);
void stp_renderer_destroy(stp_renderer* renderer);

/// Draws. `image` has the view's width and height; its pixels are the caller's. For a view with two
/// eyes, each eye gets its half: the views of select/eyes.h side by side. Statistics cover both.
STP_MUST_USE stp_result stp_renderer_draw(stp_renderer* renderer, const stp_view* view,
                                          const stp_draw_list* list, const stp_draw_style* style,
                                          stp_image* image, stp_draw_stats* stats);

/// Selects and draws in two passes with occlusion culling. Content occluded in the renderer's
/// previous picture is deferred, and drawn afterwards if the new picture does not occlude it. Fills
/// `list`; ignores `quality->occlusion`. The picture is the same as with stp_select without
/// occlusion and stp_renderer_draw, except at equal depths; earlier pictures affect only the time.
/// Each sample and each eye has two passes. Filters also blend occluded splats, so these are not
/// deferred. Drawn in one pass: parallel projection, splat counts, fixed-size points, and splats
/// drawn larger than selected.
/// @return as stp_select, stp_select_rejected and stp_renderer_draw
STP_MUST_USE stp_result stp_renderer_draw_selected(stp_renderer* renderer, const stp_view* view,
                                                   const stp_quality* quality,
                                                   const stp_draw_style* style, stp_draw_list* list,
                                                   stp_image* image, stp_draw_stats* stats);

/// Selects, and draws one more sample of a view at rest, shifted by a fraction of a pixel. The
/// picture is the mean of all samples since view, list or style last changed. After
/// style->supersample squared samples (at least 2 x 2), it equals the supersampled picture except
/// for rounding, and further calls draw nothing. Other pictures in between may restart the samples.
/// Fills `list`; ignores `quality->occlusion`. stats->samples is the number of samples.
/// @return as stp_select and stp_renderer_draw
STP_MUST_USE stp_result stp_renderer_accumulate(stp_renderer* renderer, const stp_view* view,
                                                const stp_quality* quality,
                                                const stp_draw_style* style, stp_draw_list* list,
                                                stp_image* image, stp_draw_stats* stats);

/// Sets a cancel flag. Drawing stops soon after *stop becomes true (from any thread), and returns
/// STP_ERROR_CANCELLED, which is not logged; the image is undefined. The next picture is not
/// affected. `stop` belongs to the caller; NULL: drawing is never cancelled. With a flag, OpenGL
/// draws in batches and waits for each.
void stp_renderer_set_stop(stp_renderer* renderer, const atomic_bool* stop);

/// Nearness of each pixel of the last frame (0: background), one sample per pixel (of the last
/// supersample): `width * height` floats owned by the renderer, for two eyes one picture after the
/// other. In perspective, nearness = near_distance / depth. Where fewer pixels were drawn
/// (stp_draw_style.resolution), that of the nearest one. NULL if out of memory (not logged).
const float* stp_renderer_depth(stp_renderer* renderer);
