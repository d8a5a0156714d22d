// SPDX-License-Identifier: MIT
// Reading and writing elliptical splats.
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/psp/ellipse.h"
#include "program/options/command.h"

/// Splats with colours; only the listed ones are written.
typedef struct tool_splats {
    const stp_ellipse* ellipses;
    const uint8_t* colors;   ///< 3 each, sRGB
    const uint32_t* indices; ///< splats to write, in this order
    uint32_t count;          ///< number of indices
    double origin[3];        ///< to be added to centres
    // for a .stip only
    const uint32_t* ranges; ///< by index, of ranks (stp_psp_rank_merges); NULL: all are drawn
    uint32_t base;          ///< with ranges: number of splats that views draw; they come first
    // by splat, as ellipses are
    const uint8_t* coverages;    ///< codes (base/splats/coverage.h); NULL: all are whole
    const uint8_t* materials;    ///< indices of shadings; NULL: the first of all
    const stp_shading* shadings; ///< NULL: one, rough and not metallic
    uint32_t shading_count;
} tool_splats;

/// Writes a binary PLY: centre, normal, major axis with its length (axis_x, axis_y, axis_z), length
/// of the minor axis (minor), red, green, blue. Written under a temporary name and renamed.
STP_MUST_USE stp_result tool_write_splats(stp_context* context, const char* path,
                                          const tool_splats* splats);

/// Splats of a file.
typedef struct tool_splat_set {
    stp_ellipse* ellipses; ///< `minor` and the length of `major` may be 0
    uint8_t* colors;       ///< 3 each, sRGB; white if the file has none
    uint32_t count;
    double origin[3]; ///< to be added to centres
} tool_splat_set;

/// Whether a file is a PLY whose points have axes, as written by tool_write_splats.
bool tool_is_splat_file(const char* path);

/// Reads such a file: binary, little-endian, properties in any order. @return STP_OK, STP_ERROR_IO,
/// STP_ERROR_FORMAT, STP_ERROR_OUT_OF_MEMORY; logged. After a failure there is nothing to destroy
STP_MUST_USE stp_result tool_read_splats(stp_context* context, const char* path,
                                         tool_splat_set* splats);
void tool_splat_set_destroy(stp_context* context, tool_splat_set* splats);
