// SPDX-License-Identifier: MIT
// Elliptical splats to the command line.
#pragma once

#include "command.h"

#include "lod/psp/ellipse.h"

/// Splats with colours, of which those that are listed are written.
typedef struct tool_splats {
    const stp_ellipse* ellipses;
    const uint8_t* colors;   ///< 3 each, sRGB
    const uint32_t* indices; ///< of those that are written
    uint32_t count;          ///< of indices
    double origin[3];        ///< to be added to centres
} tool_splats;

/// Writes a binary PLY: centre, normal, the major axis with its length (axis_x, axis_y, axis_z), the length of the minor axis
/// (minor), red, green, blue. Written aside and renamed.
STP_MUST_USE stp_result tool_write_splats(stp_context* context, const char* path,
                                          const tool_splats* splats);
