// SPDX-License-Identifier: MIT
//
// The OpenGL 4.5 core backend: takes the same lists and gives the same pictures as the CPU backend.
//
// The host creates the context and keeps it current on the calling thread. This code creates no
// context and opens no library; it loads the context's functions once through `get_proc_address`.
// Requires, beyond 4.5 core, ARB_shader_draw_parameters and ARB_indirect_parameters (both core in
// 4.6).
//
// Between calls the host owns the context's state. After a call, no program, vertex array,
// framebuffer or buffer is bound, the depth test is off, and clip control and depth range have
// their defaults. The viewport, indexed binding points and texture units are undefined.
#pragma once

#include "draw/draw.h"

typedef void (*stp_gl_proc)(void);

typedef struct stp_draw_gl_desc {
    /// Returns a function of the current context, or NULL: eglGetProcAddress,
    /// SDL_GL_GetProcAddress, ...
    stp_gl_proc (*get_proc_address)(const char* name, void* user);
    void* user;
    uint64_t memory_bytes; ///< limit on GPU memory for scene data; default 1 GiB
    /// Upload limit in bytes per frame, for data that a coarser level can replace; 0: uploads
    /// everything before drawing, as a single picture needs.
    uint64_t upload_bytes;
    /// Receives the messages of a debug context: the first error fails the call in which it occurs.
    bool debug;
} stp_draw_gl_desc;

/// The context must be current here and in every call that takes the renderer, including its
/// destruction.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the context lacks something);
/// logged
STP_MUST_USE stp_result stp_draw_gl_create(stp_context* context, stp_store* store,
                                           const stp_draw_gl_desc* desc, stp_renderer** renderer);

/// A renderer of this backend is used like any other. Its drawing calls also accept `image` NULL:
/// then the picture stays on the GPU, and the call does not wait for it.
///
/// The texture that holds the last picture: GL_TEXTURE_2D, GL_RGBA8, bytes as in stp_image (sRGB
/// values, not marked as such), row 0 the top row. It belongs to the renderer, and changes with the
/// picture size.
uint32_t stp_draw_gl_texture(const stp_renderer* renderer);

/// Gets what the GPU knows of the last picture: times (draw_ms, shade_ms, effect_ms, layer_ms),
/// splats, fragments and covered pixels. They are known when the picture is finished: if it stayed
/// on the GPU, call this after a fence or glFinish, or the call waits. Leaves the other fields of
/// `stats` unchanged, as set by the drawing call.
void stp_draw_gl_finish_stats(stp_renderer* renderer, stp_draw_stats* stats);

/// How splats are drawn; the picture is the same.
typedef enum stp_gl_splats {
    STP_GL_SPLATS_AUTO,    ///< the fastest by measurement for the drawn content
    STP_GL_SPLATS_POINTS,  ///< point primitives
    STP_GL_SPLATS_COMPUTE, ///< a compute shader, in two passes over the splats
} stp_gl_splats;

/// Default AUTO, with which the first picture takes somewhat longer.
void stp_draw_gl_set_splats(stp_renderer* renderer, stp_gl_splats splats);

enum { STP_GL_SPLAT_SIZES = 3 };

/// Measurements for choosing a splat path. All zero: none yet.
typedef struct stp_draw_gl_speed {
    float sizes[STP_GL_SPLAT_SIZES]; ///< diameters, pixels
    /// By path (stp_gl_splats less 1): nanoseconds per splat of each size, and fixed cost. 0: path
    /// not available.
    double splat_ns[2][STP_GL_SPLAT_SIZES], fixed_ns[2];
} stp_draw_gl_speed;

stp_draw_gl_speed stp_draw_gl_get_speed(const stp_renderer* renderer);

typedef struct stp_draw_gl_stats {
    uint64_t memory_bytes;   ///< limit for scene data
    uint64_t resident_bytes; ///< used for scene data
    uint64_t uploaded_bytes; ///< in the last frame, for all eyes
    /// Items that the last frame wanted finer than resident, summed over the eyes; 0: the picture
    /// is complete
    uint32_t missing;
    uint32_t coming; ///< uploads postponed to later frames; 0 with missing items: memory is full
    uint32_t draw_calls;  ///< OpenGL draw calls of the last frame (one sample)
    uint32_t dispatches;  ///< compute dispatches of the last frame (one sample)
    bool is_software;     ///< software renderer on a CPU
    stp_gl_splats splats; ///< splat path of the last frame
    /// CPU times of the last picture: preparing its data (uploads included), issuing its commands,
    /// and, with an image, waiting for the GPU and reading the pixels
    double prepare_ms, issue_ms, read_ms;
    const char* device; ///< name of the context's renderer
} stp_draw_gl_stats;

stp_draw_gl_stats stp_draw_gl_get_stats(const stp_renderer* renderer);
