// SPDX-License-Identifier: MIT
// What is seen at a place of a picture, as JSON.
#pragma once

#include "show_options.h"

#include <stipple/view.h>

/// Two numbers with a comma between them. @return false where the text is none
bool pick_read_place(const char* text, double place[2]);

/// What the pixel at column and row shows, of original triangles and points. NULL: logged or printed.
json_t* pick_describe(scene_show* show, const stp_view* view, const double place[2]);
