// SPDX-License-Identifier: MIT
//
// A painter draws pictures of a model, either on the CPU into the caller's pixels, or in the
// caller's OpenGL context. Both draw the same picture.
#pragma once

#include <stipple/image.h>
#include <stipple/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Keeps decoded textures, scratch memory and the frame-time controller between pictures. Belongs
/// to its model.
typedef struct stp_painter stp_painter;

typedef void (*stp_gl_function)(void);

/// All zero: draws on the CPU.
typedef struct stp_painter_desc {
    size_t struct_size;
    /// Returns a function of the current OpenGL context, or NULL: SDL_GL_GetProcAddress,
    /// eglGetProcAddress, ... If set, the painter draws with OpenGL. The context needs version 4.5
    /// core with ARB_indirect_parameters and ARB_shader_draw_parameters, and must be current in
    /// every call that takes the painter. Only stp_painter_create calls this.
    stp_gl_function (*get_proc_address)(const char* name, void* user);
    void* gl_user;
    uint64_t gl_memory_bytes; ///< limit on GPU memory for the scene; default 1 GiB
    /// Upload limit in bytes per frame, for data whose coarser level can be drawn instead; 0:
    /// upload everything a picture needs.
    uint64_t gl_upload_bytes;
    bool gl_debug; ///< fails on errors that a debug context reports
    /// Lets stp_painter_set_stopped abandon pictures. OpenGL then draws in smaller batches, which
    /// is somewhat slower.
    bool can_stop;
} stp_painter_desc;

/// @param desc  NULL: all zero
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the OpenGL context lacks
/// something)
STP_API STP_MUST_USE stp_result stp_painter_create(stp_model* model, const stp_painter_desc* desc,
                                                   stp_painter** painter);

/// With OpenGL, its context must be current. NULL is allowed.
STP_API void stp_painter_destroy(stp_painter* painter);

/// Colouring of pixels.
typedef enum stp_pixel_coloring {
    STP_PIXELS_OWN,       ///< colours of the scene (for points: stp_model_desc.point_coloring)
    STP_PIXELS_ELEVATION, ///< by height in the scene
    STP_PIXELS_NORMALS,   ///< by surface normal, unlit
} stp_pixel_coloring;

/// Whether pictures with one sample a pixel pass the pixel filter: each pixel becomes a mean of
/// itself and its neighbours, which calms what aliases while the view moves.
typedef enum stp_pixel_filter {
    STP_PIXEL_FILTER_AUTO, ///< with budget_ms, without accumulate and triangles_only
    STP_PIXEL_FILTER_ON,
    STP_PIXEL_FILTER_OFF,
} stp_pixel_filter;

/// Drawing options. All zero: splats of one pixel in the scene's colours on a transparent
/// background.
typedef struct stp_paint_desc {
    size_t struct_size;
    /// Diameter in pixels, at least 1; default 1. Larger splats draw faster and coarser
    float splat_size;
    /// Above 0: frame-time budget in milliseconds. The painter chooses the splat size from previous
    /// frames, never below `splat_size`; it adapts over the first frames. Without `accumulate`,
    /// effects are left out while there is no time for them beside fine splats, in this order:
    /// ambient occlusion, all `samples` but one, all layers of transparent surfaces but the nearest.
    /// Then that layer becomes a pattern of pixels. Where even splats of 24 pixels take too long, the
    /// CPU draws fewer pixels, and enlarges the picture: stp_paint_report.resolution.
    double budget_ms;
    uint64_t splat_count; ///< above 0: total number of splats, instead of a size
    const char* method;   ///< method whose splats are drawn: "blue", ...; NULL: the file's default
    bool triangles_only;  ///< reference: every triangle and point, no splats. Not while streaming
    bool splats_only;     ///< no triangles where splats exist
    /// While streaming: draws repeatedly until everything the view needs is loaded, or memory is
    /// full.
    bool complete;
    uint32_t samples; ///< n x n samples per pixel, at most 64; default 1
    /// Draws one more of the n x n samples (n at least 2) in each call, while view and options stay
    /// the same; the picture is the mean of the samples so far. For a view at rest.
    bool accumulate;
    bool smooth;     ///< blends overlapping splats (EWA)
    bool headlight;  ///< light from the eye; default: from above left of the eye
    bool background; ///< fill with background_color; default: transparent black
    uint8_t background_color[3];
    float eye_dome; ///< strength of eye-dome lighting; 0: none
    /// Radius of ambient occlusion, relative to the picture's height; 0: none
    float ambient_occlusion;
    float ghost; ///< share of a ghost's pixels that is drawn, 0 to 1; 0: a fifth
    bool caps;   ///< closes solids where the view's sections cut them
    stp_pixel_coloring coloring;
    double elevation[2]; ///< heights (y) at the ends of the colour scale; both 0: the scene's own
    /// Bytes from the start of a row of the caller's pixels to that of the next, at least
    /// 4 * width; 0: 4 * width. The bytes between rows stay as they are.
    size_t stride;
    /// Draws the backs of single-sided materials of glTF files, too.
    bool back_faces;
    stp_pixel_filter pixel_filter;
} stp_paint_desc;

typedef struct stp_paint_report {
    size_t struct_size;
    double frame_ms; ///< duration of the last drawing pass; with OpenGL, until commands were sent
    double select_ms, draw_ms, shade_ms;
    float splat_size; ///< as used: pixels of the whole picture
    /// Drawn: splats of the wanted level in the picture, triangles of clusters in view. A picture
    /// that stays an OpenGL texture has an upper bound
    uint64_t splat_count, triangle_count;
    uint64_t covered_pixels; ///< of those drawn (`resolution`)
    uint32_t samples;        ///< per pixel, so far
    uint32_t missing;        ///< items drawn coarser than wanted because they are not loaded
    uint32_t coming;         ///< those of them that later pictures will have
    /// Share of the picture's width and height that was drawn, then enlarged: below 1 where the
    /// largest splats do not meet stp_paint_desc.budget_ms
    float resolution;
} stp_paint_report;

/// Draws a picture.
///
/// @param view    its width and height are the picture's
/// @param desc    NULL: all zero
/// @param image the caller's pixels, of the view's size (rows: stp_paint_desc.stride); NULL (OpenGL
/// only): the picture stays in stp_painter_get_texture, and the call does not wait for the GPU
/// @param report  may be NULL
/// @return STP_OK; STP_ERROR_ARGUMENT (invalid view, options or image), STP_ERROR_LIMIT,
/// STP_ERROR_FORMAT (damaged data), STP_ERROR_UNSUPPORTED (the OpenGL context was lost),
/// STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (stp_painter_set_stopped; not logged). After a
/// failure the pixels are undefined, and the painter can draw again.
///
/// OpenGL: between calls the caller owns the context's state. A call leaves no program, vertex
/// array, framebuffer or buffer bound, depth test and blending off, and the viewport, indexed
/// bindings and texture units undefined.
STP_API STP_MUST_USE stp_result stp_painter_draw(stp_painter* painter, const stp_view* view,
                                                 const stp_paint_desc* desc, stp_image* image,
                                                 stp_paint_report* report);

/// The OpenGL texture that holds the last picture: GL_TEXTURE_2D, GL_RGBA8, sRGB values, row 0 at
/// the top. Belongs to the painter; changes with the picture size. 0 for a CPU painter, and if the
/// last picture failed.
STP_API uint32_t stp_painter_get_texture(const stp_painter* painter);

/// Depth of each pixel of the last picture: distance from the eye along the viewing direction, in
/// scene units; infinity for background. Rows as in the picture (with `samples`: of the last
/// sample). Not available for views with two eyes or in parallel projection. With OpenGL this waits
/// for the GPU.
/// @param depths  receives width * height numbers of the last view
/// @return STP_OK, STP_ERROR_ARGUMENT (no depths, or not `count` pixels), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_painter_get_depths(stp_painter* painter, float* depths,
                                                       size_t count);

/// While true, drawing stops as soon as possible with STP_ERROR_CANCELLED, also if it is set to
/// false again meanwhile; set it to false before the next picture. Only for painters made with
/// `can_stop`; others ignore it. Callable from any thread between create and destroy.
STP_API void stp_painter_set_stopped(stp_painter* painter, bool stopped);

#ifdef __cplusplus
}
#endif
