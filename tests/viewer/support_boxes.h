// SPDX-License-Identifier: MIT
//
// A small scene for tests of the viewer.
#pragma once

#include <stdbool.h>

/// Builds scene:boxes into a file of this process and returns its path; the caller removes it.
bool boxes_build(const char* name, char path[64]);
