// SPDX-License-Identifier: MIT
// Splats drawn by whatever OpenGL runs without a window here, for comparison: on machines without a graphics
// processor that is Mesa's llvmpipe.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct software_gl software_gl;

/// A context of OpenGL 4.5 with a picture to draw into, on `threads` threads where it is llvmpipe; NULL where there
/// is none. One at a time.
software_gl* software_gl_create(uint32_t width, uint32_t height, uint32_t threads);
void software_gl_destroy(software_gl* gl);
/// What draws, as it calls itself.
const char* software_gl_name(const software_gl* gl);

/// Hands over positions (3 floats each, clip space) and normals (3 floats each). @return false where it fails
bool software_gl_upload(software_gl* gl, const float* positions, const float* normals,
                        uint32_t count);
/// Clears and draws all as points: squares of one colour, or oriented disks (Brandt 4.2). Returns when done.
void software_gl_draw(software_gl* gl, float size_px, bool disks);
/// The same with a single point: what has to be compiled for it is there afterwards.
void software_gl_warm(software_gl* gl, float size_px, bool disks);
