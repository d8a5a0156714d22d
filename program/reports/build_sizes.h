// SPDX-License-Identifier: MIT
//
// Input and output sizes of a build: the last lines of `stipple build`.
#pragma once

#include "program/reports/describe.h"

/// Size of the inputs in bytes: each file, and the buffers and pictures that a .gltf names. Named
/// scenes and unreadable files count as 0.
uint64_t build_sizes_input(const char* const* inputs, size_t count);

/// Whether the file has splats although the scene has no points and so few triangles (counting all
/// uses) that drawing all of them is quick.
bool build_sizes_needs_no_splats(const scene_figures* figures);

/// Prints on stdout: a notice if splats are not needed, the reason if the output is more than three
/// times as large as the input, and the sizes of both.
void build_sizes_print(uint64_t input_bytes, const scene_figures* figures);
