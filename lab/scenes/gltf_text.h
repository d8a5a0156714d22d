// SPDX-License-Identifier: MIT
// The JSON of a glTF file: lab/scenes/gltf_file.h.
#pragma once

#include "base/io/file.h"
#include "lab/scenes/gltf_plan.h"

/// Appends the JSON. `name`: prefix of the binary files ("plant.bin" is "plant"); NULL: the only
/// buffer is in the same file.
STP_MUST_USE stp_result gltf_json_write(const gltf_plan* plan, const char* name,
                                        stp_file_writer* file);

/// The name of a binary file: NAME.bin, NAME-2.bin, ...
void gltf_buffer_name(char* out, size_t size, const char* name, size_t buffer);
