// SPDX-License-Identifier: MIT
// The interactive viewer, for `stipple view`.
#pragma once

#include "program/options/cloud_style.h"
#include "program/options/point_colors.h"
#include "program/viewer/model/settings.h"

#include <stipple/view.h>

typedef struct viewer_options {
    const char* const* files; ///< shown as one scene
    size_t file_count;        ///< 0: start page
    char up;                  ///< scene_input
    double unit_metres;
    const char* view;           ///< name of the first view; NULL: iso
    uint32_t width, height;     ///< size of the window, in the display's units
    float scale;                ///< scale of text and panels; 0: that of the display
    bool software;              ///< show the window without OpenGL
    int backend;                ///< 0: as in the last session; 1: CPU; 2: OpenGL
    int gl_splats;              ///< how OpenGL draws splats: an stp_gl_splats
    float budget_ms;            ///< 0: as in the last session
    uint32_t method;            ///< STP_METHOD_* to draw; 0: as in the last session
    uint32_t cues_off;          ///< STP_CUE_*_BIT to ignore
    uint32_t splat_count;       ///< number of splats; 0: as in the last session
    point_color_options colors; ///< initial colours of points
    cloud_point_size point_size;
    bool has_point_size;             ///< else as in the last session
    bool back_faces, has_back_faces; ///< else as in the last session
    uint32_t thread_count;
    uint64_t memory_limit;
    const char* report; ///< path of the JSON state report; NULL: none
} viewer_options;

/// @return the exit code; messages are printed
int viewer_run(const viewer_options* options);
