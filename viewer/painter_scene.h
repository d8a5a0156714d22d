// SPDX-License-Identifier: MIT
// What the painter's thread has of an opened file.
#pragma once

#include "painter.h"

typedef struct paint_scene {
    painter_scene shown;
    stp_context* context;
    stp_store* store;
    stp_renderer* renderer;
    stp_residency* residency; ///< NULL: the file is used as it is mapped
    stp_draw_list list;
    stp_budget budget;
} paint_scene;

typedef struct paint_scene_desc {
    uint32_t thread_count;
    uint64_t memory_limit;
    void (*log)(stp_log_level level, const char* message, void* user);
    void* log_user;
} paint_scene_desc;

/// @return NULL where the file cannot be opened; logged
paint_scene* paint_scene_open(const paint_scene_desc* desc, const char* path, uint32_t serial);
void paint_scene_close(paint_scene* s);

/// Draws one frame, or accumulates one more where `accumulates`.
stp_result paint_scene_draw(paint_scene* s, const paint_request* request, float splat_size,
                            bool accumulates, stp_image* image, paint_figures* figures);
/// The near distance of the last frame.
double paint_near_distance(const stp_view* view);
