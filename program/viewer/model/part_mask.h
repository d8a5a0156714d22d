// SPDX-License-Identifier: MIT
//
// Where a part is in a picture: in front, and behind what hides it. Computed from its original
// triangles and the depths of the picture, at half of the picture's resolution.
#pragma once

#include "select/visibility.h"

#include <stipple/view.h>

enum { PART_SHAPE_TRIANGLES = 100000 }; ///< larger parts have no shape

/// The triangles of a part.
typedef struct part_shape {
    stp_vec3d origin; ///< in scene space
    float* corners;   ///< 9 per triangle, relative to the origin; malloc'ed
    size_t count;
} part_shape;

/// Reads the triangles of an object. Empty if it is too large or cannot be read.
void part_shape_make(stp_context* context, stp_store* store, const stp_placed_node* placed,
                     part_shape* shape);
void part_shape_destroy(part_shape* shape);

enum { PART_MASK_CELL = 2 }; ///< pixels of the picture per cell, in both directions

typedef enum part_cell { PART_CELL_NONE, PART_CELL_HIDDEN, PART_CELL_VISIBLE } part_cell;

typedef struct part_mask {
    uint32_t width, height; ///< cells
    uint8_t* cells;         ///< part_cell; malloc'ed
    float* nearness;        ///< of the part, 1 / depth; malloc'ed
    size_t visible, hidden; ///< number of such cells
} part_mask;

/// Draws a shape into the mask of a view's picture. `nearness`: near_distance / depth of each pixel
/// (0: nothing is there); NULL: not known, all of the part counts as visible. @return false if
/// memory runs out: the mask is empty
bool part_mask_draw(part_mask* mask, const part_shape* shape, const stp_view* view,
                    const float* nearness, double near_distance);
void part_mask_destroy(part_mask* mask);
