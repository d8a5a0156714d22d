// SPDX-License-Identifier: MIT
// Prevents outputs from replacing inputs.
#pragma once

/// Checks that writing `output` is safe: it is neither `input` nor an existing file beside it that
/// the input names, such as a texture of a glTF or of an OBJ's material library. Either may be
/// NULL. @return 0, or 2 (message printed)
int overwrite_check(const char* input, const char* output);
