// SPDX-License-Identifier: MIT
// Writing triangles.
#pragma once

#include "program/options/command.h"

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
