// SPDX-License-Identifier: MIT
// A small scene through the public interface alone: a box, balls, and scanned points.
#pragma once

#include "tests.h"

#include <stipple/stipple.h>

enum { EMBED_SIDE = 96, EMBED_POINTS = 1500 };

/// Adds to a builder: object "town" with "box" (a cube of side 2 around the origin), "balls" (3
/// places, 1,152 triangles each, at y = 4) and, where wanted, loose points ("scan", at z = -6, with
/// intensity and classes 2 and 6).
stp_result embed_add_town(stp_builder* builder, bool points);

/// The town as a `.stip`, in malloc memory aligned to 64 bytes; NULL on failure.
void* embed_build_town(bool points, size_t* size);
/// The same with a number of threads.
void* embed_build_town_on(uint32_t threads, bool points, size_t* size);

/// From the front, far enough to see everything.
stp_view embed_view(void);

/// Draws into pixels of EMBED_SIDE x EMBED_SIDE.
stp_result embed_draw(stp_model* model, const stp_paint_desc* desc, uint8_t* pixels);
