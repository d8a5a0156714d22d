// SPDX-License-Identifier: MIT
//
// Draws the window's pictures on a separate thread, so that the window never waits for a picture.
//
// While the camera moves, the splat size follows the frame-time budget. At rest, splats shrink step
// by step, then frames with sub-pixel shifts are accumulated. A new request aborts this refinement
// immediately, even within a frame.
#pragma once

#include "draw/draw_gl.h"
#include "draw/frame_effects.h"
#include "program/viewer/model/explorer.h"
#include "store/file/point_attributes.h"

#include <limits.h>

typedef struct painter painter;

enum { SCENE_METHODS = 8 }; ///< methods per file offered to the user

/// An opened file. The window may read it until it adopts a newer one.
typedef struct painter_scene {
    uint32_t serial; ///< never 0
    const stp_store* store;
    const stp_store_directory* directory;
    stp_boxd bounds;                      ///< empty if the scene is
    uint32_t splat_counts[SCENE_METHODS]; ///< per method of the directory (splat_count.h)
    char path[PATH_MAX];
} painter_scene;

/// The picture to draw.
typedef struct paint_request {
    uint32_t scene; ///< serial; 0: nothing
    stp_view view;
    stp_draw_style style;
    stp_store_coloring points; ///< colours of points, and hidden classes
    stp_quality quality;       ///< splat_size: at rest if there is a budget, else always
    double budget_ms;          ///< frame time while the camera moves; 0: no limit
    stp_controller controller; ///< keeps the frame time within the budget
    uint32_t samples;          ///< per axis, accumulated at rest; 1: no accumulation
    bool gl;                   ///< use OpenGL if possible
} paint_request;

/// Figures of a picture.
typedef struct paint_figures {
    double frame_ms, select_ms, draw_ms, shade_ms;
    stp_frame_cost cost;        ///< its time excludes GPU work for other frames in between
    uint64_t splats, triangles; ///< drawn; `cost` counts splats that were looked at
    uint64_t nodes;
    uint64_t live_bytes; ///< memory in use by the renderer's context
    double latency_ms;   ///< from the request to its first picture
    uint32_t layers;     ///< of transparent surfaces, at most in a pixel
    uint32_t samples;    ///< accumulated frames; 1: none were accumulated
    uint32_t missing;    ///< things wanted but not loaded, or not drawn yet
    bool exceeds;        ///< it was not drawn (stp_draw_stats.exceeds)
} paint_figures;

typedef struct painter_picture {
    stp_image image;
    float* nearness;      ///< per pixel, as from stp_renderer_depth
    stp_view view;        ///< the view of the picture
    bool gl;              ///< drawn by OpenGL
    uint32_t texture;     ///< holds the picture instead of the image; 0: none
    bool is_empty;        ///< nothing is visible
    uint32_t scene;       ///< serial
    uint64_t number;      ///< number of the request, from painter_request
    uint64_t frame;       ///< number of pictures so far, of all requests
    bool complete;        ///< no better picture of this request follows
    double near_distance; ///< nearness is near_distance / depth, in perspective
    paint_figures figures;
    size_t capacity; ///< pixels
} painter_picture;

typedef struct painter_desc {
    uint32_t thread_count;
    uint64_t memory_limit;    ///< 0: none, and files are memory-mapped
    void (*wake)(void* user); ///< called on the painter thread when there is news
    void* user;
    /// Makes an OpenGL context current on the calling thread until end_gl; false: there is none.
    bool (*begin_gl)(void* user);
    void (*end_gl)(void* user);
    stp_gl_proc (*get_proc_address)(const char* name, void* user);
    void* gl_user;
    stp_gl_splats gl_splats; ///< how OpenGL draws splats, if it is used
} painter_desc;

/// @return NULL if a thread or memory is not available
painter* painter_create(const painter_desc* desc);
void painter_destroy(painter* p);

/// Opens a .stip, for painter_adopt.
void painter_open(painter* p, const char* path, uint32_t serial);
/// Returns the last opened file once; NULL: nothing new. The previous file is valid until the next
/// request.
const painter_scene* painter_adopt(painter* p);

/// Sets the visibility of a scene from now on. Takes over the list's objects and empties it.
void painter_show(painter* p, uint32_t scene, shown_list* list);

/// Replaces the previous request. @return a number, which is the same if nothing changed
uint64_t painter_request(painter* p, const paint_request* request);
/// Returns the newest picture once; NULL: nothing new. The window may use it until the next call.
const painter_picture* painter_take(painter* p);

/// Returns the last error or warning since the last call, once. @return false if there is none
bool painter_get_message(painter* p, char* message, size_t size, bool* is_error);
