// SPDX-License-Identifier: MIT
//
// A painter: draws a model for one view after the other, into the caller's pixels with the CPU, or in the caller's
// OpenGL context. Both draw the same picture.
#pragma once

#include <stipple/image.h>
#include <stipple/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Keeps decoded textures, scratch memory and the frame-time controller from picture to picture. Belongs to its model.
typedef struct stp_painter stp_painter;

typedef void (*stp_gl_function)(void);

/// All zero: the CPU draws.
typedef struct stp_painter_desc {
    size_t struct_size;
    /// Gives a function of the current OpenGL context, or NULL: SDL_GL_GetProcAddress, eglGetProcAddress, ... Set: OpenGL
    /// draws. The context needs version 4.5 core with ARB_indirect_parameters and ARB_shader_draw_parameters, and must
    /// be current in every call that takes the painter. Only stp_painter_create calls this.
    stp_gl_function (*get_proc_address)(const char* name, void* user);
    void* gl_user;
    uint64_t gl_memory_bytes; ///< most graphics memory for the scene; default 1 GiB
    /// Most bytes uploaded in a frame where something coarser can be shown meanwhile; 0: all that a picture needs.
    uint64_t gl_upload_bytes;
    bool gl_debug; ///< fails on errors that a debug context reports
    /// Lets stp_painter_set_stopped abandon pictures. OpenGL then draws in portions, somewhat slower.
    bool can_stop;
} stp_painter_desc;

/// @param desc  NULL: all zero
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the OpenGL context lacks something)
STP_API STP_MUST_USE stp_result stp_painter_create(stp_model* model, const stp_painter_desc* desc,
                                                   stp_painter** painter);

/// With OpenGL, its context must be current. NULL is allowed.
STP_API void stp_painter_destroy(stp_painter* painter);

/// What colours pixels have.
typedef enum stp_pixel_coloring {
    STP_PIXELS_OWN,       ///< colours of the scene (for points: stp_model_desc.point_coloring)
    STP_PIXELS_ELEVATION, ///< by height in the scene
    STP_PIXELS_NORMALS,   ///< by surface normal, without light
} stp_pixel_coloring;

/// What to draw and how. All zero: splats of one pixel in the scene's colours on a transparent background.
typedef struct stp_paint_desc {
    size_t struct_size;
    float
        splat_size; ///< diameter in pixels, at least 1; default 1. Larger draws faster and coarser
    /// Above 0: milliseconds a frame may take. The painter chooses the splat size from the frames before, never below
    /// `splat_size`; the first frames learn.
    double budget_ms;
    uint64_t splat_count; ///< above 0: so many splats in all, instead of a size
    const char* method;   ///< whose splats: "blue", ...; NULL: as the file suggests
    bool
        triangles_only; ///< every triangle and point of the scene, no splats: the reference. Not while streaming
    bool splats_only; ///< no triangles where there are splats
    /// Draws again until all that the view wants is loaded, or memory is full. Of use while streaming.
    bool complete;
    uint32_t samples; ///< n x n samples a pixel, at most 64; default 1
    /// Draws one more of the n x n samples (n at least 2) in each call, as long as view and options stay: the picture is the
    /// mean of those so far. For a view at rest.
    bool accumulate;
    bool smooth;     ///< splats that overlap are blended (EWA)
    bool headlight;  ///< light from the eye; default: from above left of it
    bool background; ///< fill with background_color; default: transparent black
    uint8_t background_color[3];
    float eye_dome;          ///< strength of eye-dome lighting; 0: none
    float ambient_occlusion; ///< reach of ambient occlusion, in heights of the picture; 0: none
    float ghost;             ///< the part of a ghost's pixels that is drawn, 0 to 1; 0: a fifth
    bool caps;               ///< solids that the view's sections cut are closed
    stp_pixel_coloring coloring;
    double elevation[2]; ///< heights (y) at the ends of the colour scale; both 0: the scene's own
} stp_paint_desc;

typedef struct stp_paint_report {
    size_t struct_size;
    double frame_ms; ///< what the call took; with OpenGL, until commands were sent
    double select_ms, draw_ms, shade_ms;
    float splat_size; ///< pixels, in effect
    uint64_t splats, triangles, covered_pixels;
    uint32_t samples; ///< of each pixel, so far
    uint32_t missing; ///< things that are coarser than wanted because they are not loaded
    uint32_t coming;  ///< of them, those that later pictures will have
} stp_paint_report;

/// Draws a picture.
///
/// @param view    its width and height are the picture's
/// @param desc    NULL: all zero
/// @param image   the caller's pixels, of the view's size, rows without gaps; NULL (OpenGL only): the picture stays in
///                stp_painter_get_texture, and the call does not wait for the GPU
/// @param report  may be NULL
/// @return STP_OK; STP_ERROR_ARGUMENT (view, options or image cannot be used), STP_ERROR_LIMIT, STP_ERROR_FORMAT
/// (damaged data), STP_ERROR_UNSUPPORTED (the OpenGL context was lost), STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED
/// (stp_painter_set_stopped; not logged). After a failure the pixels are undefined, and the painter can draw again.
///
/// OpenGL: between calls the context's state is the caller's. A call leaves no program, vertex array, framebuffer or
/// buffer bound (indexed bindings and texture units are left as they fall), depth test and blending off, and the
/// viewport undefined.
STP_API STP_MUST_USE stp_result stp_painter_draw(stp_painter* painter, const stp_view* view,
                                                 const stp_paint_desc* desc, stp_image* image,
                                                 stp_paint_report* report);

/// The OpenGL texture that holds the last picture: GL_TEXTURE_2D, GL_RGBA8, sRGB values, row 0 at the top. Belongs to
/// the painter; changes when the size of pictures does. 0 of a painter that uses the CPU.
STP_API uint32_t stp_painter_get_texture(const stp_painter* painter);

/// Distance along the gaze from the eye to what each pixel of the last picture shows, in scene units; infinity where
/// nothing is. Rows as in the picture (of a picture with `samples`: of the last sample). For a view of two eyes or in
/// parallel projection there are none. With OpenGL this waits for the GPU.
/// @param depths  receives width * height numbers of the last view
/// @return STP_OK, STP_ERROR_ARGUMENT (no picture yet, or not of `count` pixels), STP_ERROR_OUT_OF_MEMORY
STP_API STP_MUST_USE stp_result stp_painter_get_depths(stp_painter* painter, float* depths,
                                                       size_t count);

/// While true, drawing stops as soon as possible with STP_ERROR_CANCELLED; set it to false before the next picture. Of a
/// painter made with `can_stop`; others ignore it. Any thread, at any time between create and destroy.
STP_API void stp_painter_set_stopped(stp_painter* painter, bool stopped);

#ifdef __cplusplus
}
#endif
