// SPDX-License-Identifier: MIT
// What a command has open that draws a scene: the context, the file, what of it is shown, and what draws.
#pragma once

#include "draw_options.h"
#include "frame.h"

/// All zero at first.
typedef struct drawing {
    stp_context* context;
    stp_store* store;
    scene_show show;
    point_coloring coloring;
    stp_splat_texture splat_texture; ///< of a file, for the maker's style
    frame_maker maker;
} drawing;

/// Makes the context. @return whether that went well, with the message printed
bool drawing_begin(drawing* d, const draw_options* options);

/// Opens a file, or builds it first. Where no method was asked for and the usual one's splats lack what --color or --classes
/// ask for, `options` name one whose splats have it, or original points, with a warning. Failures are logged.
STP_MUST_USE stp_result drawing_open(drawing* d, draw_options* options, const char* path);

/// Makes what draws the open scene; under a limit of memory, it loads what it needs. Failures are logged.
STP_MUST_USE stp_result drawing_make(drawing* d, const draw_options* options);

/// What draws, pictures of what size, and of how much of the file: "backend", "device", "width", "height", "truncated",
/// "file_bytes" (there, or drawn of), "whole_bytes". NULL where memory runs out.
json_t* drawing_describe(const drawing* d, const stp_view* view);

/// Closes whatever is open, the context last.
void drawing_end(drawing* d);
