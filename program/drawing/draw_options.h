// SPDX-License-Identifier: MIT
// The options shared by all commands that draw: size, renderer, quality.
#pragma once

#include "program/drawing/drawing_table.h"
#include "program/drawing/show_options.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/point_colors.h"
#include "select/budget.h"

typedef struct draw_options {
    uint32_t size[2];
    double fov; ///< 0: not given
    int backend;
    int gl_splats; ///< stp_gl_splats
    drawing_settings settings;
    double budget_ms; ///< 0: none
    int controller;
    int method; ///< place in stp_methods
    bool has_method;
    int hybrid; ///< HYBRID_*
    option_partial_file partial_file;
    const char *fovea, *fovea_center, *cues;
    bool stereo;
    double ipd;                ///< 0: not given
    const char* splat_texture; ///< a file
    int transparency;          ///< TRANSPARENCY_*
    int pixel_filter;          ///< PIXEL_FILTER_*
    bool in_motion;            ///< set by the command: frames follow each other
    const char* point_size;
    point_color_options colors;
    show_options show;
    uint64_t threads, memory;
    bool json;
} draw_options;

/// Names of stp_methods, as words of an option.
#define TOOL_METHOD_WORDS "blue|spt|psp|stochastic"

/// Fills a table of OPTION_TABLE_ROOM entries: the command's own (ends with a NULL name), and the
/// shared ones, of which it resets the drawing settings. @return the table
const option* draw_options_table(option* table, const option* own, draw_options* options);

/// Rejects options that exclude each other and invalid values. @return 0, or 2 (message printed)
int draw_options_check(const draw_options* options);

/// Checks that a store has splats by a method (STP_METHOD_*; 0: any), or no splats at all. @return
/// 0, or 1 (message printed)
int tool_check_method(uint32_t id, const stp_store* store, const char* path);
/// Same for the requested method.
int draw_options_check_method(const draw_options* options, const stp_store* store,
                              const char* path);
/// Name of the method that is drawn; NULL if there are no splats. Valid as long as the store.
const char* draw_options_method(const draw_options* options, const stp_store* store);
/// Same for the method drawn beside it where few splats suffice; NULL if none.
const char* draw_options_coarse_method(const draw_options* options, const stp_store* store);

/// Quality from the options, which must have been checked.
stp_quality draw_options_quality(const draw_options* options);
stp_draw_style draw_options_style(const draw_options* options);

/// A view of the requested size and angle (0: not given).
stp_view draw_options_view(const draw_options* options);

/// Distance between the eyes in scene units; 0: one eye.
double draw_options_eye_distance(const draw_options* options, const stp_store* store);

/// Whether no option sets the quality, neither the choice of splats nor the samples per pixel.
bool draw_options_leave_quality(const draw_options* options);

/// The content that a scene needs for these options.
scene_use draw_options_use(const draw_options* options);
