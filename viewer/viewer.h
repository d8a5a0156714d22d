// SPDX-License-Identifier: MIT
// The interactive viewer, for `stipple view`.
#pragma once

#include "cloud_look.h"
#include "point_colors.h"
#include "settings.h"

#include <stipple/view.h>

typedef struct viewer_options {
    const char* file;           ///< NULL: a window that asks for one
    const char* view;           ///< name of the first view; NULL: iso
    uint32_t width, height;     ///< of the window
    float scale;                ///< of text; 0: the display's
    bool software;              ///< the window without OpenGL
    int backend;                ///< 0: as last time; 1: processor; 2: OpenGL
    int gl_splats;              ///< how OpenGL draws splats: an stp_gl_splats
    float budget_ms;            ///< 0: as last time
    uint32_t method;            ///< STP_METHOD_*, whose splats are drawn; 0: as last time
    uint32_t cues_off;          ///< STP_CUE_*_BIT that are not looked at
    uint32_t splat_count;       ///< so many splats are drawn; 0: as last time
    point_color_options colors; ///< of points, at first
    cloud_point_size point_size;
    bool has_point_size; ///< else as last time
    uint32_t thread_count;
    uint64_t memory_limit;
    const char* report; ///< a file that says in JSON what is shown; NULL: none
} viewer_options;

/// @return the exit code; messages are printed
int viewer_run(const viewer_options* options);
