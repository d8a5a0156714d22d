// SPDX-License-Identifier: MIT
// CPU culling of mesh clusters, and the drawn share of each.
#pragma once

#include "draw/gl/gl_renderer.h"

/// Adds commands for the clusters of a placed mesh item that may be visible.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result stp_gl_cull_mesh(stp_gl_renderer* r, uint32_t index);

/// The same for an item of large triangles: adds commands for the clusters that contain some. The
/// shader skips the other triangles.
STP_MUST_USE stp_result stp_gl_cull_large(stp_gl_renderer* r, uint32_t index);
