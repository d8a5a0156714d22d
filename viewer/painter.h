// SPDX-License-Identifier: MIT
//
// Draws what the window is to show, on a thread of its own: the window never waits for a picture.
//
// While the camera moves, splats are as large as the budget of time asks. Once it rests they shrink step by step, and then
// frames that are each shifted by a part of a pixel are accumulated. A new request abandons such a refinement at once, in the
// middle of a frame.
#pragma once

#include "explorer.h"

#include "draw/draw_gl.h"
#include "select/budget.h"
#include "store/coloring.h"

#include <limits.h>

typedef struct painter painter;

enum { SCENE_METHODS = 8 }; ///< of a file, that are offered

/// An opened file. What the window may read of it while it is the newest that the window adopted.
typedef struct painter_scene {
    uint32_t serial; ///< never 0
    const stp_store* store;
    const stp_store_directory* directory;
    stp_boxd bounds;                      ///< empty where the scene is
    uint32_t splat_counts[SCENE_METHODS]; ///< of each method of the directory (splat_count.h)
    char path[PATH_MAX];
} painter_scene;

/// What to draw.
typedef struct paint_request {
    uint32_t scene; ///< serial; 0: nothing
    stp_view view;
    stp_draw_style style;
    stp_store_coloring points; ///< colours of points, and hidden classes
    stp_quality quality;       ///< splat_size: at rest, where there is a budget; else always
    double budget_ms;          ///< of a frame while the camera moves; 0: none
    stp_controller controller; ///< of the budget
    uint32_t samples;          ///< a side, accumulated at rest; 1: none
    bool gl;                   ///< by OpenGL, where it can
} paint_request;

/// What a picture took.
typedef struct paint_figures {
    double frame_ms, select_ms, draw_ms, shade_ms;
    /// What of frame_ms was work on this frame: without what the graphics processor did for others in between.
    double work_ms;
    float splat_size;
    uint64_t splats, triangles, fragments, covered_pixels, draw_calls, nodes;
    uint64_t live_bytes; ///< of the renderer's context
    double latency_ms;   ///< from asking for this view to its first picture
    uint32_t samples;    ///< accumulated
    uint32_t missing;    ///< things wanted and not loaded, or not drawn yet
} paint_figures;

typedef struct painter_picture {
    stp_image image;
    float* nearness;      ///< a pixel, as stp_renderer_depth gives it
    stp_view view;        ///< that it is of
    bool gl;              ///< drawn by OpenGL
    uint32_t texture;     ///< that it is in, instead of the image's pixels; 0: none
    bool is_empty;        ///< nothing is to be seen in it
    uint32_t scene;       ///< serial
    uint64_t number;      ///< of the request, as painter_request returned it
    uint64_t frame;       ///< pictures of any request so far
    bool complete;        ///< of its request, none better comes
    double near_distance; ///< nearness is this by depth, in perspective
    paint_figures figures;
    size_t capacity; ///< pixels
} painter_picture;

typedef struct painter_desc {
    uint32_t thread_count;
    uint64_t memory_limit;    ///< 0: none, and files are used as they are mapped
    void (*wake)(void* user); ///< called from the thread where there is news
    void* user;
    /// Makes an OpenGL context current on the calling thread; false: there is none. Until end_gl.
    bool (*begin_gl)(void* user);
    void (*end_gl)(void* user);
    stp_gl_proc (*get_proc_address)(const char* name, void* user);
    void* gl_user;
    stp_gl_splats gl_splats; ///< how OpenGL draws splats, where it can
} painter_desc;

/// @return NULL where there is no thread or memory
painter* painter_create(const painter_desc* desc);
void painter_destroy(painter* p);

/// Opens a .stip, for painter_adopt.
void painter_open(painter* p, const char* path, uint32_t serial);
/// What was opened last, once; NULL: nothing new. What the one before gave ends with the next request.
const painter_scene* painter_adopt(painter* p);

/// What of a scene is shown from now on. The list's things are the painter's.
void painter_show(painter* p, uint32_t scene, shown_list* list);

/// Asks for a picture instead of what was asked before. @return a number; the same where nothing changed
uint64_t painter_request(painter* p, const paint_request* request);
/// The newest picture, once; NULL: nothing new. It is the window's until the next call.
const painter_picture* painter_take(painter* p);

/// The last failure or warning since the last call, once. @return false where there is none
bool painter_get_message(painter* p, char* message, size_t size, bool* is_error);
