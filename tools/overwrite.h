// SPDX-License-Identifier: MIT
// No output may replace an input.
#pragma once

/// Whether writing `output` is safe: it is neither `input` nor an existing file beside it that the input names, such as a
/// texture of a glTF, or of a material library of an OBJ. Either may be NULL. @return 0, or 2 (message printed)
int overwrite_check(const char* input, const char* output);
