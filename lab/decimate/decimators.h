// SPDX-License-Identifier: MIT
// The methods of `stipple-lab decimate` to compare Progressive Splatting with.
#pragma once

#include "program/files/point_file.h"
#include "program/options/command.h"

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

// Writing triangles.

/// Triangles with a colour at each vertex. Arrays belong to the caller.
typedef struct tool_triangles {
    const float* vertices;     ///< 3 each
    const uint8_t* colors;     ///< 3 per vertex, sRGB
    const uint32_t* triangles; ///< 3 vertices each
    uint32_t vertex_count, triangle_count;
    double origin[3]; ///< to be added to vertices
} tool_triangles;

/// Writes a binary PLY: vertices with colours, and faces as lists of indices. Written aside and
/// renamed.
STP_MUST_USE stp_result tool_write_triangles(stp_context* context, const char* path,
                                             const tool_triangles* triangles);
