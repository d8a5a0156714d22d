// SPDX-License-Identifier: MIT
// State of a command that draws a scene: context, file, visibility and renderer.
#pragma once

#include "program/drawing/draw_options.h"
#include "program/drawing/frame.h"
#include "program/present/viewpoints.h"
#include "store/file/store.h"

/// All zero at first.
typedef struct drawing {
    stp_context* context;
    stp_store* store;
    scene_show show;
    point_coloring coloring;
    stp_splat_texture splat_texture; ///< read from a file; the maker's style points to it
    frame_maker maker;
} drawing;

/// Creates the context. @return whether it succeeded; the message is printed
bool drawing_begin(drawing* d, const draw_options* options);

/// Opens a file, or builds it first. If no method was requested and the default method's splats
/// lack what --color or --classes need, `options` switches to a suitable method or to original
/// points, with a warning. Failures are logged.
STP_MUST_USE stp_result drawing_open(drawing* d, draw_options* options, const char* path);

/// Creates the renderer of the open scene; with a memory limit, it loads on demand. Failures are
/// logged.
STP_MUST_USE stp_result drawing_make(drawing* d, const draw_options* options);

/// Describes renderer, picture size and the used part of the file: "backend", "device", "width",
/// "height", "truncated", "file_bytes" (existing or used), "whole_bytes". NULL if memory runs out.
json_t* drawing_describe(const drawing* d, const stp_view* view);

/// Closes everything that is open, the context last.
void drawing_end(drawing* d);

// The named views of a scene.

/// Prints that no view has that name and lists those that exist: the file's, those saved beside it,
/// and the standard ones. @return 2
int view_list_refuse(const char* name, const stp_store* store, const stp_viewpoints* viewpoints);
