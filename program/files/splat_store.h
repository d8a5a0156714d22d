// SPDX-License-Identifier: MIT
// Elliptical splats as a .stip, which every command draws.
#pragma once

#include "program/files/splat_file.h"
#include "store/file/store.h"

// The .stip has one set with the splats in their order, by method `psp`: all of them are drawn from
// any distance, or the first N with --splats N; splats with ranges are the states of a progressive
// set. The file's precision applies: 16 bits per
// coordinate, 8 bits for each component of a normal and for the direction of the major axis, radii
// up to 0.8 % too large. It contains neither points nor triangles.

/// Writes splats to a .stip if the name ends so, else as tool_write_splats.
/// @param up the file's up axis: splats lie along its own axes (tool_own_axes)
/// @return STP_OK, STP_ERROR_ARGUMENT (no splats), STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result tool_write_any_splats(stp_context* context, const char* path,
                                              const tool_splats* splats, char up);

/// Opens splats as a scene: such a .stip, as an unlinked file in $TMPDIR.
/// @return as tool_write_any_splats and stp_store_open; logged
STP_MUST_USE stp_result tool_open_splat_store(stp_context* context, const tool_splats* splats,
                                              char up, stp_store** store);
