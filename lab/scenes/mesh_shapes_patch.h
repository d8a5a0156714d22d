// SPDX-License-Identifier: MIT
//
// Output of shapes: space for a known number of vertices and triangles at the end of the builder's
// arrays, with cursors. Loops that fill a patch neither allocate nor check.
#pragma once

#include "lab/scenes/mesh_shapes.h"

typedef struct shape_patch {
    float *position, *normal;
    uint32_t* index;
    uint32_t first; ///< index of the first vertex
    stp_affine place;
} shape_patch;

/// Adds to the counts. @return whether to write: false when only counting, out of memory, or if the
/// shape is left out (then it is not counted either)
bool shape_begin(shaper* s, uint64_t vertices, uint64_t triangles, shape_patch* patch);

/// The circle with `sides` sides.
const shape_ring* shape_circle(shaper* s, int sides);

static inline void patch_vertex(shape_patch* p, double x, double y, double z, double nx, double ny,
                                double nz)
{
    for (int row = 0; row < 3; ++row) {
        const double* m = p->place.m[row];
        p->position[row] = (float)(m[0] * x + m[1] * y + m[2] * z + m[3]);
        p->normal[row] = (float)(m[0] * nx + m[1] * ny + m[2] * nz);
    }
    p->position += 3;
    p->normal += 3;
}

static inline void patch_triangle(shape_patch* p, uint32_t a, uint32_t b, uint32_t c)
{
    p->index[0] = a;
    p->index[1] = b;
    p->index[2] = c;
    p->index += 3;
}

/// Corners in counter-clockwise order, seen from outside.
static inline void patch_quad(shape_patch* p, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    patch_triangle(p, a, b, c);
    patch_triangle(p, a, c, d);
}
