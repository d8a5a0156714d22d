// SPDX-License-Identifier: MIT
// The methods of `stipple-lab decimate` to compare Progressive Splatting with.
#pragma once

#include "program/files/point_file.h"

/// Values of --by. The first one is psp, which has its own options and report.
#define DECIMATOR_WORDS "psp|octree|octree-level|quadric|mesh|blue|subsample"

/// The input of a decimator.
typedef struct tool_decimation {
    int by; ///< index of a word, 1 or more
    const tool_points* points;
    const uint8_t* colors; ///< 3 per point, sRGB; NULL: white
    uint32_t target;       ///< splats, or vertices of `mesh`
    const char* output;
    bool json;
} tool_decimation;

/// Decimates, writes the file, and prints figures. @return the exit status; errors are logged
int tool_decimate_by(stp_context* context, const tool_decimation* task);
