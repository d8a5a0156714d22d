// SPDX-License-Identifier: MIT
// Which clusters of a mesh are drawn, and how much of them: on the processor.
#pragma once

#include "draw/gl/renderer.h"

/// Adds commands for the clusters of a mesh item that may be seen; it is placed.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result gl_cull_mesh(gl_renderer* r, uint32_t index);

/// The same for an item of large triangles: adds commands for the clusters that have some. The shader leaves out the others.
STP_MUST_USE stp_result gl_cull_large(gl_renderer* r, uint32_t index);
