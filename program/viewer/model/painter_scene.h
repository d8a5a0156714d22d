// SPDX-License-Identifier: MIT
// An opened file, as used by the painter thread.
#pragma once

#include "draw/draw_gl.h"
#include "program/viewer/model/paint_thread.h"

typedef struct paint_scene {
    painter_scene shown;
    stp_context* context;
    stp_store* store;
    stp_renderer* renderers[2]; ///< for the CPU, and for OpenGL once it is used
    bool loads;                 ///< there is a memory limit
    bool gl_failed;             ///< OpenGL cannot draw it
    bool transparent;           ///< it has transparent surfaces
    stp_visibility* visibility; ///< NULL: everything is visible
    stp_residency* residency;   ///< NULL: the file is memory-mapped
    stp_draw_list list;
    stp_budget budgets[2];
} paint_scene;

typedef struct paint_scene_desc {
    uint32_t thread_count;
    uint64_t memory_limit;
    void (*log)(stp_log_level level, const char* message, void* user);
    void* log_user;
} paint_scene_desc;

/// @return NULL if the file cannot be opened; logged
paint_scene* paint_scene_open(const paint_scene_desc* desc, const char* path, uint32_t serial);
/// Called on the thread that drew it.
void paint_scene_close(paint_scene* s);

/// Creates the OpenGL renderer if needed. @return whether OpenGL can draw the scene
bool paint_scene_use_gl(paint_scene* s, const stp_draw_gl_desc* gl, stp_gl_splats splats);
/// Colours points from now on as requested. A change reloads all data. @return whether the scene
/// can be drawn; else the error is logged
bool paint_scene_color(paint_scene* s, const stp_store_coloring* points);
/// Aborts frames from now on when *stop becomes true (stp_renderer_set_stop); NULL: never.
void paint_scene_set_stop(paint_scene* s, const atomic_bool* stop);
/// Sets the visibility from now on.
stp_result paint_scene_show(paint_scene* s, const shown_list* list);

/// Draws one frame, or accumulates one more if `accumulates`. Without an image it stays in OpenGL's
/// texture.
stp_result paint_scene_draw(paint_scene* s, const paint_request* request, float splat_size,
                            bool accumulates, bool gl, stp_image* image, paint_figures* figures);
/// Whether both ask for the same picture.
bool paint_is_same_request(const paint_request* a, const paint_request* b);
/// Near distance of a view in perspective, also if the view leaves it to the renderer.
double paint_near_distance(const stp_view* view);

// OpenGL pictures, kept in textures that the window shows while the next one is drawn.

enum { PAINTER_GL_SLOTS = 3 };

typedef struct painter_gl_functions painter_gl_functions;

typedef struct painter_gl {
    painter_gl_functions* functions; ///< NULL: OpenGL is not available
    uint32_t textures[PAINTER_GL_SLOTS];
    uint32_t width[PAINTER_GL_SLOTS], height[PAINTER_GL_SLOTS];
} painter_gl;

// These need a current context.
bool painter_gl_create(painter_gl* g, const stp_draw_gl_desc* desc);
void painter_gl_destroy(painter_gl* g);
/// Copies a picture into a slot's texture and waits for completion. @return the texture; 0: out of
/// memory
uint32_t painter_gl_keep(painter_gl* g, int slot, uint32_t picture, uint32_t width,
                         uint32_t height);
