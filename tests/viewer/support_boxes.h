// SPDX-License-Identifier: MIT
//
// A small scene for tests of the viewer.
#pragma once

#include <stdbool.h>

/// Builds scene:boxes into a file in the current folder; `path` receives its name, with `name` and
/// the process id. The caller removes it. @return whether it was built
bool boxes_build(const char* name, char path[64]);
