// SPDX-License-Identifier: MIT
// Memory of the painter's pictures: pixels, and their nearness for the cursor.
#pragma once

#include "program/viewer/model/paint_thread.h"

/// Makes room for a picture's size; its content is lost. @return false if memory runs out
bool picture_memory_fit(painter_picture* picture, uint32_t width, uint32_t height);
/// Copies the nearness of all pixels, as from stp_renderer_depth; NULL: there is none. Sets is_empty.
void picture_memory_copy_depth(painter_picture* picture, const float* nearness);
void picture_memory_free(painter_picture* picture);
