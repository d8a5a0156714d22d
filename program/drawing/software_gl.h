// SPDX-License-Identifier: MIT
// Draws splats with an offscreen OpenGL context of a software renderer (Mesa's llvmpipe), for
// comparison.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct software_gl software_gl;

/// Creates an OpenGL 4.5 context with a picture to draw into, with `threads` threads for llvmpipe;
/// NULL if not available. One at a time.
software_gl* software_gl_create(uint32_t width, uint32_t height, uint32_t threads);
void software_gl_destroy(software_gl* gl);
/// Name of the OpenGL device.
const char* software_gl_name(const software_gl* gl);

/// Uploads positions (3 floats each, clip space) and normals (3 floats each). @return false on
/// failure
bool software_gl_upload(software_gl* gl, const float* positions, const float* normals,
                        uint32_t count);
/// Clears and draws all as points: squares of one colour, or oriented disks (Brandt 4.2). Returns
/// when finished.
void software_gl_draw(software_gl* gl, float size_px, bool disks);
/// Same with a single point, to compile the shaders beforehand.
void software_gl_warm(software_gl* gl, float size_px, bool disks);
