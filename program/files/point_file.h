// SPDX-License-Identifier: MIT
// Point sets from and to the command line.
#pragma once

#include "base/io/spill.h"
#include "program/options/command.h"

#include <stipple/types.h>

/// The points of a file: point sets and vertices of meshes.
typedef struct tool_points {
    uint32_t count;
    /// To be added to the positions: that of the caller, else the translation of the first part
    double origin[3];
    float* positions;    ///< 3 per point, along the file's own axes
    float* normals;      ///< 3 per point, unit or zero; NULL: the file has none
    uint8_t* colors;     ///< RGBA a point, sRGB; NULL: the file has none
    uint32_t* triangles; ///< 3 points each; NULL: the file has none, or nobody asked
    uint32_t triangle_count;
    char up;          ///< the file's up axis: x, y or z
    stp_spill* spill; ///< in the folder of the output; NULL: none was needed
    bool spilled;     ///< positions, normals and colors are in `spill`
} tool_points;

/// Converts a position of a scene to the axes of its source file, as far as known: a scene's y is
/// up. `up`: the file's up axis.
stp_vec3d tool_own_axes(char up, stp_vec3d place);
/// The inverse conversion.
stp_vec3d tool_scene_axes(char up, stp_vec3d place);

/// Reads a file of any importable format. `origin` (may be NULL: chosen from the file) replaces the
/// origin, so that two files can be compared. Failures are logged by the context.
STP_MUST_USE stp_result tool_read_points(stp_context* context, const char* path,
                                         const double* origin, tool_points* points);
/// Processes the points of a file. @return the exit status
typedef int (*tool_points_worker)(stp_context* context, const char* path, tool_points* points);

/// A command that reads one file of points and writes another file.
typedef struct tool_points_command {
    const char *name, *input,
        *output; ///< as help names them, such as "order", "file of points", "ORDERED.ply"
    tool_points_worker work;
    bool triangles; ///< it needs those of meshes, too
    bool spills;    ///< data that exceeds the memory may go to a file in the folder of the output
} tool_points_command;

/// Runs it.
/// @param path of the output; NULL if not given.
/// @param memory limit in bytes; 0: no limit
/// @return the exit status; errors are printed
int tool_run_on_points(const tool_points_command* task, int argc, char** argv, const char* path,
                       uint64_t threads, uint64_t memory);
/// Creates `points->spill` if it does not exist.
/// @param output a file in the folder.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result tool_points_open_spill(stp_context* context, const char* output,
                                               tool_points* points);
void tool_points_destroy(stp_context* context, tool_points* points);

/// Writes a PLY position as three floats or, with the origin added, as three doubles. @return bytes
/// written
size_t tool_put_position(unsigned char* bytes, const float* position, const double* origin,
                         bool doubles);

/// Writes points in the given order as a binary PLY.
STP_MUST_USE stp_result tool_write_points(stp_context* context, const char* path,
                                          const tool_points* points, const uint32_t* order,
                                          uint32_t count);
