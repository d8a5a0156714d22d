// SPDX-License-Identifier: MIT
// Reports what is visible at a position of the picture, as JSON.
#pragma once

#include "program/drawing/show_options.h"

#include <stipple/view.h>

/// Reads two numbers separated by a comma. @return false on a syntax error
bool pick_read_place(const char* text, double place[2]);

/// Reports the original triangles or points at a pixel. NULL on failure: logged or printed.
json_t* pick_describe(scene_show* show, const stp_view* view, const double place[2]);
