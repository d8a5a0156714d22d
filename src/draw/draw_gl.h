// SPDX-License-Identifier: MIT
//
// The backend that draws with OpenGL 4.5 core: the same lists, and the same pictures, as the processor's.
//
// The host makes the context and keeps it current on the thread that calls; nothing here creates one or opens a
// library. All that is needed of the context is its functions, asked of `get_proc_address` once. Needed beyond 4.5 core:
// ARB_shader_draw_parameters and ARB_indirect_parameters (both core in 4.6).
//
// Between calls the context's state is the host's. A call leaves behind it: no program, vertex array, framebuffer or
// buffer bound (indexed binding points and texture units are left as they fall), depth test off, clip control and
// depth range as at first, the viewport undefined.
#pragma once

#include "draw/draw.h"

typedef void (*stp_gl_proc)(void);

typedef struct stp_draw_gl_desc {
    /// Gives a function of the current context, or NULL: eglGetProcAddress, SDL_GL_GetProcAddress, ...
    stp_gl_proc (*get_proc_address)(const char* name, void* user);
    void* user;
    uint64_t memory_bytes; ///< most graphics memory for what scenes are made of; default 1 GiB
    /// Most bytes that are uploaded in a frame where something coarser can be shown instead; 0: all that the frame shows
    /// is uploaded before it is drawn, as a single picture wants it. See stp_draw_gl_set_upload_bytes.
    uint64_t upload_bytes;
    /// Listens to the context's debug messages (a debug context has them): the first error fails the call it occurs in.
    bool debug;
} stp_draw_gl_desc;

/// The context must be current, here and in every call that takes the renderer, its destruction included.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the context lacks something); logged
STP_MUST_USE stp_result stp_draw_gl_create(stp_context* context, stp_store* store,
                                           const stp_draw_gl_desc* desc, stp_renderer** renderer);

/// A renderer of this backend draws as every other; its stp_renderer_draw and its like also take `image` NULL: then
/// the picture stays here, and the call does not wait for the graphics processor.
///
/// The texture that holds the last picture: GL_TEXTURE_2D, GL_RGBA8, bytes as in stp_image (sRGB values, not marked as
/// such), row 0 the top row. It is the renderer's, and changes when the size of pictures does.
uint32_t stp_draw_gl_texture(const stp_renderer* renderer);

/// What the last picture took of the graphics processor (draw_ms, shade_ms, fragments) and what it covers: known once it is
/// done, so to be asked for after a fence or glFinish where the picture stayed here; before, the call waits for it. The other
/// figures of `stats`, which are those that the drawing call gave, are left as they are.
void stp_draw_gl_finish_stats(stp_renderer* renderer, stp_draw_stats* stats);

/// See stp_draw_gl_desc.upload_bytes.
void stp_draw_gl_set_upload_bytes(stp_renderer* renderer, uint64_t bytes);

/// How splats are drawn; the picture is the same.
typedef enum stp_gl_splats {
    STP_GL_SPLATS_AUTO,    ///< whichever was measured to be fastest for what is drawn
    STP_GL_SPLATS_POINTS,  ///< point primitives
    STP_GL_SPLATS_COMPUTE, ///< a compute shader, in two passes over the splats
} stp_gl_splats;

/// AUTO at first: then the first picture takes somewhat longer.
void stp_draw_gl_set_splats(stp_renderer* renderer, stp_gl_splats splats);

enum { STP_GL_SPLAT_SIZES = 3 };

/// What was measured to choose among ways of drawing splats. All zero: nothing yet.
typedef struct stp_draw_gl_speed {
    float sizes[STP_GL_SPLAT_SIZES]; ///< diameters, pixels
    /// By way (stp_gl_splats less 1): nanoseconds a splat of each size, and whatever is drawn. 0: there is no such way.
    double splat_ns[2][STP_GL_SPLAT_SIZES], fixed_ns[2];
} stp_draw_gl_speed;

stp_draw_gl_speed stp_draw_gl_get_speed(const stp_renderer* renderer);

typedef struct stp_draw_gl_stats {
    uint64_t memory_bytes;   ///< that may be used for what scenes are made of
    uint64_t resident_bytes; ///< of it, in use
    uint64_t uploaded_bytes; ///< in the last frame, for all eyes
    uint32_t
        missing; ///< things that the last frame wanted finer than they were there, summed over the eyes; 0: the picture is complete
    uint32_t
        coming; ///< uploads put off to the next frames; with things missing and 0: there is no room for more
    uint32_t draw_calls;  ///< OpenGL draw calls of the last frame (one sample)
    uint32_t dispatches;  ///< compute dispatches of the last frame (one sample)
    bool is_software;     ///< drawn by a processor
    stp_gl_splats splats; ///< how those of the last frame were drawn
    const char* device;   ///< what the context calls itself
} stp_draw_gl_stats;

stp_draw_gl_stats stp_draw_gl_get_stats(const stp_renderer* renderer);
