// SPDX-License-Identifier: MIT
// The options shared by all commands that draw: size, renderer, quality.
#pragma once

#include "draw/draw.h"
#include "program/drawing/show_options.h"
#include "program/files/scene_file.h"
#include "program/options/command.h"
#include "program/options/point_colors.h"
#include "select/budget.h"

typedef struct draw_options {
    uint32_t size[2];
    double fov;
    bool has_fov;
    int backend;
    int gl_splats; ///< stp_gl_splats
    double splat_size, splat_scale, budget_ms;
    uint64_t splats;
    bool has_splat_size, has_splats, has_budget;
    int policy, controller;
    int method;                  ///< place in stp_methods
    int hybrid, normal_clusters; ///< HYBRID_*, CLUSTERS_*
    bool has_method;
    bool reference;
    option_partial_file partial_file;
    const char *fovea, *fovea_center, *cues;
    bool stereo, has_ipd;
    double ipd;
    uint64_t supersample;
    int light;
    uint8_t background[3];
    bool has_background;
    int filter, splat_shape;
    const char* splat_texture; ///< a file
    int transparency;          ///< TRANSPARENCY_*
    bool in_motion;            ///< set by the command: frames follow each other
    double eye_dome, ambient_occlusion;
    bool has_eye_dome;
    const char* point_size;
    point_color_options colors;
    int caps; ///< CAPS_ON, CAPS_OFF
    show_options show;
    uint64_t threads, memory;
    bool json;
} draw_options;

/// Names of stp_methods, as words of an option.
#define TOOL_METHOD_WORDS "blue|spt|psp|stochastic"

enum { DRAW_OPTION_ROOM = 104 }; ///< entries of a table

/// Fills a table of DRAW_OPTION_ROOM entries: the command's own (ends with a NULL name), and after
/// them the shared ones.
/// @return the table
const option* draw_options_table(option* table, const option* own, draw_options* options);

/// Rejects options that exclude each other and invalid values. @return 0, or 2 (message printed)
int draw_options_check(const draw_options* options);

/// Whether a store has splats by a method (STP_METHOD_*; 0: any). @return 0, or 1 (message printed)
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
