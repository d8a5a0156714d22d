// SPDX-License-Identifier: MIT
// Frames of a scene: selected, drawn, shaded and timed.
#pragma once

#include "draw/frame_effects.h"
#include "program/options/command.h"
#include "program/present/headless.h"

/// Figures and times of a frame.
typedef struct frame_figures {
    stp_frame_cost cost; ///< of the whole frame: selected, drawn and shaded
    double select_ms, draw_ms, shade_ms;
    bool exceeds;               ///< it was not drawn (stp_draw_stats.exceeds)
    uint32_t left_out;          ///< effects that it was drawn without (stp_budget_left_out)
    uint64_t splats, triangles; ///< drawn; `cost` counts what was looked at to draw them
    uint64_t extra_splats;      ///< listed while levels blend
    uint64_t clusters, nodes;
    uint32_t layers;  ///< layers of transparent surfaces
    uint32_t missing; ///< resources the view needs that were not, or not completely, loaded
    bool on_gl;       ///< drawn by OpenGL, which fills these (stp_draw_gl_stats):
    double prepare_ms, issue_ms, read_ms;
    uint64_t uploaded_bytes, gl_bytes; ///< the latter: used for scene data
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
/// Same, on a backend; frame_maker_create uses the CPU. Automatic: OpenGL if a GPU provides it.
STP_MUST_USE stp_result frame_maker_create_on(stp_context* context, stp_store* store,
                                              const stp_draw_style* style, frame_backend backend,
                                              frame_maker* maker);
/// Same, in an existing OpenGL context, which the maker takes over in any case. Automatic: the CPU
/// if the context lacks something.
STP_MUST_USE stp_result frame_maker_create_in(stp_context* context, stp_store* store,
                                              const stp_draw_style* style, frame_backend backend,
                                              const stp_headless* headless, frame_maker* maker);
/// How OpenGL draws splats, if it is used: an stp_gl_splats.
void frame_maker_use_splats(frame_maker* maker, int splats);
/// "cpu" or "gl".
const char* frame_backend_name(const frame_maker* maker);
/// Loads bulk data on demand from now on, within the context's memory limit; loads the coarsest
/// data immediately.
STP_MUST_USE stp_result frame_maker_stream(frame_maker* maker);
void frame_maker_destroy(frame_maker* maker);

/// Draws a view for one eye or two; `image` has its size. Failures are logged by the context.
/// With OpenGL, `image` may be NULL: the picture stays on the GPU, and this waits for it.
STP_MUST_USE stp_result frame_draw(frame_maker* maker, const stp_view* view,
                                   const stp_quality* quality, stp_image* image,
                                   frame_figures* figures);

/// Draws the originals, without approximation, with `side` x `side` samples a pixel, with or without
/// the pixel filter. `visibility` may be NULL.
STP_MUST_USE stp_result frame_draw_originals(frame_maker* maker, const stp_view* view,
                                             const stp_visibility* visibility, uint32_t side,
                                             bool filtered, stp_image* image);

/// Draws a view repeatedly until everything it wants is loaded, or memory is full.
STP_MUST_USE stp_result frame_draw_loaded(frame_maker* maker, const stp_view* view,
                                          const stp_quality* quality, stp_image* image,
                                          frame_figures* figures);

/// Draws the next of `count` accumulated frames (stp_renderer_accumulate); count is above one.
STP_MUST_USE stp_result frame_accumulate(frame_maker* maker, const stp_view* view,
                                         const stp_quality* quality, uint32_t count,
                                         stp_image* image);

/// Draws the view until the budget settles on a splat size; gives up after 150 frames, 20 seconds
/// or an interrupt. Sets quality->splat_size. Draws without the effects that the budget leaves out.
STP_MUST_USE stp_result frame_settle(frame_maker* maker, const stp_view* view, stp_budget* budget,
                                     stp_quality* quality, stp_image* image);

/// Allocates a picture with stp_alloc. @return false, with the message printed
bool frame_image_create(stp_context* context, uint32_t width, uint32_t height, stp_image* image);
/// Same; evicts data that the maker loaded if needed.
bool frame_maker_create_image(frame_maker* maker, uint32_t width, uint32_t height,
                              stp_image* image);

/// An operation that needs memory and has no effect if there is none; it then returns
/// STP_ERROR_OUT_OF_MEMORY (logged).
typedef stp_result (*frame_task)(void* user);
/// Runs it; if memory runs out, evicts data that the maker loaded and runs it again. The last
/// failure is logged.
STP_MUST_USE stp_result frame_do(frame_maker* maker, frame_task task, void* user);

/// Describes frame figures as in `render --json`. NULL if memory runs out.
json_t* frame_describe(const frame_figures* figures);

/// Describes the renderer and the picture: `backend`, `device`, `width`, `height`. NULL if memory
/// runs out.
json_t* frame_maker_describe(const frame_maker* maker, uint32_t width, uint32_t height);
/// Bytes in memory: the context's count, and the size of the file if it is mapped.
uint64_t frame_maker_resident_bytes(const frame_maker* maker);
