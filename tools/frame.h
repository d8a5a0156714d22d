// SPDX-License-Identifier: MIT
// Frames of a scene, one after the other: selected, drawn, shaded, and timed.
#pragma once

#include "command.h"

#include "draw/draw.h"
#include "present/headless.h"
#include "select/budget.h"

/// What a frame was, and how long it took.
typedef struct frame_figures {
    double frame_ms, select_ms, draw_ms, shade_ms; ///< the first is select, draw and shade
    float splat_size;                              ///< in effect
    uint64_t splats, triangles, fragments, covered_pixels;
    uint64_t extra_splats; ///< drawn while levels blend
    uint64_t clusters, nodes, draw_calls;
    uint32_t layers;  ///< of transparent surfaces
    uint32_t missing; ///< things the view wants that were not, or not wholly, loaded
} frame_figures;

/// All zero at first.
typedef struct frame_maker {
    stp_context* context;
    stp_store* store; ///< borrowed
    stp_renderer* renderer;
    stp_residency* residency; ///< NULL: the file is used as it is mapped
    stp_draw_list list;
    stp_draw_style style;
    stp_headless headless; ///< where OpenGL draws
    bool uses_gl;
} frame_maker;

typedef enum frame_backend {
    FRAME_BACKEND_AUTO,
    FRAME_BACKEND_CPU,
    FRAME_BACKEND_GL
} frame_backend;

STP_MUST_USE stp_result frame_maker_create(stp_context* context, stp_store* store,
                                           const stp_draw_style* style, frame_maker* maker);
/// The same on a backend; frame_maker_create's is the processor. Automatic: OpenGL where a graphics processor gives it.
STP_MUST_USE stp_result frame_maker_create_on(stp_context* context, stp_store* store,
                                              const stp_draw_style* style, frame_backend backend,
                                              frame_maker* maker);
/// The same where OpenGL has a context, which becomes the maker's, whatever is returned. Automatic: the processor draws where
/// the context lacks something.
STP_MUST_USE stp_result frame_maker_create_in(stp_context* context, stp_store* store,
                                              const stp_draw_style* style, frame_backend backend,
                                              const stp_headless* headless, frame_maker* maker);
/// How OpenGL, if it is used, draws splats: an stp_gl_splats.
void frame_maker_use_splats(frame_maker* maker, int splats);
/// "cpu" or "gl".
const char* frame_backend_name(const frame_maker* maker);
/// From now on bulk data is loaded under the context's limit of memory; the coarsest of it is there at once.
STP_MUST_USE stp_result frame_maker_stream(frame_maker* maker);
void frame_maker_destroy(frame_maker* maker);

/// Draws a view, of one eye or two; `image` has its size. Failures are logged by the context.
STP_MUST_USE stp_result frame_draw(frame_maker* maker, const stp_view* view,
                                   const stp_quality* quality, stp_image* image,
                                   frame_figures* figures);

/// Draws a view again and again until all that it wants is there, or as much as memory has room for.
STP_MUST_USE stp_result frame_draw_loaded(frame_maker* maker, const stp_view* view,
                                          const stp_quality* quality, stp_image* image,
                                          frame_figures* figures);

/// Draws the next of `count` frames that are accumulated (stp_renderer_accumulate), of which there are more than one.
STP_MUST_USE stp_result frame_accumulate(frame_maker* maker, const stp_view* view,
                                         const stp_quality* quality, uint32_t count,
                                         stp_image* image);

/// Draws the view until the budget has found its size of splats and stays there, or does not find it in some hundred
/// frames or so many seconds. Sets quality->splat_size.
STP_MUST_USE stp_result frame_settle(frame_maker* maker, const stp_view* view, stp_budget* budget,
                                     stp_quality* quality, stp_image* image);

/// What a budget learns of a frame.
stp_frame_cost frame_cost(const frame_figures* figures);

/// A picture's memory, from stp_alloc. @return false, with the message printed
bool frame_image_create(stp_context* context, uint32_t width, uint32_t height, stp_image* image);
/// The same, to which what the maker loaded gives way.
bool frame_maker_create_image(frame_maker* maker, uint32_t width, uint32_t height,
                              stp_image* image);

/// Something that needs memory and leaves nothing done where there is none. @return STP_ERROR_OUT_OF_MEMORY (logged) then
typedef stp_result (*frame_task)(void* user);
/// Does it; where memory runs out, what the maker loaded gives way and it is done again. A last failure is logged.
STP_MUST_USE stp_result frame_do(frame_maker* maker, frame_task task, void* user);

/// The keys of frame figures as `render --json` has them. NULL where memory runs out.
json_t* frame_describe(const frame_figures* figures);

/// What draws, and pictures of which size: `backend`, `device`, `width`, `height`. NULL where memory runs out.
json_t* frame_maker_describe(const frame_maker* maker, uint32_t width, uint32_t height);
/// Bytes in memory: what the context counts, and without a limit the file as it is mapped.
uint64_t frame_maker_resident_bytes(const frame_maker* maker);

/// What draws calls itself: the processor, or what OpenGL says.
void frame_read_device(const frame_maker* maker, char* name, size_t size);
