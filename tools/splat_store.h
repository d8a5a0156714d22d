// SPDX-License-Identifier: MIT
// Elliptical splats as a .stip, which every command draws.
#pragma once

#include "splat_file.h"

#include "store/store.h"

/// Writes a .stip whose only node has these splats as its set, in their order, of method `psp`: all
/// of them are drawn from any distance, or the first N with --splats N. The file's own precision
/// holds: 16 bits a coordinate, 8 bits for each number of a normal and for the direction of the
/// larger axis, radii up to 0.8 % too large. Neither points nor triangles are in it.
/// @param up the file's up axis: splats lie along its own axes (tool_own_axes)
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result tool_write_splat_store(stp_context* context, const char* path,
                                               const tool_splats* splats, char up);

/// Writes splats to a .stip where the name ends so, else as tool_write_splats.
STP_MUST_USE stp_result tool_write_any_splats(stp_context* context, const char* path,
                                              const tool_splats* splats, char up);

/// Opens splats as a scene: of tool_write_splat_store, in a file of $TMPDIR that has no name any more.
/// @return as that and stp_store_open; logged
STP_MUST_USE stp_result tool_open_splat_store(stp_context* context, const tool_splats* splats,
                                              char up, stp_store** store);
