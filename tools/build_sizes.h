// SPDX-License-Identifier: MIT
//
// The bytes that went into a build and those that it wrote: the last lines of `stipple build`.
#pragma once

#include "describe.h"

/// Bytes of the inputs: of each file, and of the buffers and pictures that a .gltf names beside it. Scenes by name and what
/// cannot be read count nothing.
uint64_t build_sizes_input(const char* const* inputs, size_t count);

/// Why a file is more than three times as large as its inputs, as an English sentence without a full stop; NULL where it is
/// not, or the inputs have no size.
const char* build_sizes_reason(uint64_t input_bytes, const scene_figures* figures);

/// Whether the scene has so few triangles, each use counted, and no points, that a frame of all of them is quick without
/// splats.
bool build_sizes_needs_no_splats(const scene_figures* figures);

/// Prints input, output, and its splats, triangles and textures; the reason; and a notice where splats are needless. On stdout.
void build_sizes_print(uint64_t input_bytes, const scene_figures* figures);
