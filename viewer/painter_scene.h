// SPDX-License-Identifier: MIT
// What the painter's thread has of an opened file.
#pragma once

#include "painter.h"

typedef struct paint_scene {
    painter_scene shown;
    stp_context* context;
    stp_store* store;
    stp_renderer* renderers[2]; ///< the processor's, and OpenGL's once it was wanted
    bool loads;                 ///< there is a limit of memory
    bool gl_failed;             ///< OpenGL cannot draw it
    bool transparent;           ///< it has transparent surfaces
    stp_visibility* visibility; ///< NULL: all is shown
    stp_residency* residency;   ///< NULL: the file is used as it is mapped
    stp_draw_list list;
    stp_budget budgets[2];
} paint_scene;

typedef struct paint_scene_desc {
    uint32_t thread_count;
    uint64_t memory_limit;
    void (*log)(stp_log_level level, const char* message, void* user);
    void* log_user;
    const stp_draw_gl_desc* gl; ///< NULL: there is no OpenGL
} paint_scene_desc;

/// @return NULL where the file cannot be opened; logged
paint_scene* paint_scene_open(const paint_scene_desc* desc, const char* path, uint32_t serial);
/// On the thread that drew it.
void paint_scene_close(paint_scene* s);

/// Makes ready to draw with OpenGL, where that was not yet. @return whether it can
bool paint_scene_use_gl(paint_scene* s, const stp_draw_gl_desc* gl, stp_gl_splats splats);
/// Colours points from now on as a request asks. Where that is new, all that was loaded is loaded again. @return whether the scene
/// can be drawn; else it is logged
bool paint_scene_color(paint_scene* s, const stp_store_coloring* points);
/// Abandons frames from now on where *stop becomes true (stp_renderer_set_stop); NULL: none.
void paint_scene_set_stop(paint_scene* s, const atomic_bool* stop);
/// What is shown from now on.
stp_result paint_scene_show(paint_scene* s, const shown_list* list);

/// Draws one frame, or accumulates one more where `accumulates`. Without an image it stays in OpenGL's texture.
stp_result paint_scene_draw(paint_scene* s, const paint_request* request, float splat_size,
                            bool accumulates, bool gl, stp_image* image, paint_figures* figures);
/// Whether they ask for the same picture.
bool paint_is_same_request(const paint_request* a, const paint_request* b);
/// The near distance of the last frame.
double paint_near_distance(const stp_view* view);
