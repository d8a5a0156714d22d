// SPDX-License-Identifier: MIT
// Pictures of a few squares, shared by tests of post-processing.
#pragma once

#include "support_store.h"
#include "tests.h"

#include "draw/draw.h"

enum { PICTURE_SIDE = 64 };

typedef struct made_picture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_draw_stats stats;
    stp_view view;
    stp_quality quality;
    stp_draw_style style;
    stp_image image;
    uint8_t pixels[PICTURE_SIDE * PICTURE_SIDE * 4];
} made_picture;

/// An empty, unlit white scene, seen from (0, 0, 5) in perspective: a square from -1 to 1 in the
/// plane z = 0 fills the middle half of the picture. @return false if out of memory
bool made_picture_begin(made_picture* p, test_heap* heap, uint32_t threads);
/// A square from -1 to 1, rotated about x and translated; with splats of one colour (NULL:
/// triangles only).
void made_picture_add(made_picture* p, double angle, stp_vec3d move, const uint8_t* color);
/// Material and shading `index`, which follows those before: of that colour, and glass if its alpha
/// is below 1.
void made_picture_add_material(made_picture* p, uint32_t index, const float color[4]);
/// A square with that material; with splats of the same opacity if `splats`.
void made_picture_add_sheet(made_picture* p, uint32_t material, double angle, stp_vec3d move,
                            bool splats);
/// Writes and opens the scene, and makes the renderer.
stp_result made_picture_open(made_picture* p);
/// Selects and draws.
stp_result made_picture_draw(made_picture* p);
stp_result made_picture_accumulate(made_picture* p);
void made_picture_end(made_picture* p);
const uint8_t* made_picture_pixel(const made_picture* p, int x, int y);
