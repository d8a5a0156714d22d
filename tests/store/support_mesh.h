// SPDX-License-Identifier: MIT
// Meshes that are unpleasant to code as clusters.
#pragma once

#include "store/clusters.h"

#include <stdbool.h>

/// Arrays are the made mesh's; as stp_store_mesh, but they may be changed.
typedef struct made_mesh {
    uint32_t vertex_count, triangle_count;
    float* positions;
    int16_t* normals;
    float* texcoords[2];
    uint16_t* colors;
    uint32_t* indices;
} made_mesh;

typedef enum made_shape {
    MADE_WAVE,      ///< a smooth sheet, vertices shared
    MADE_SOUP,      ///< the same, each triangle with vertices of its own
    MADE_SCATTERED, ///< unconnected triangles all over the place
    MADE_BOXES,     ///< hard edges: four vertices a face
    MADE_SLIVERS,   ///< the sheet, a thousand times longer than wide, with degenerate triangles
    MADE_UNEVEN,    ///< one huge triangle over a sheet of tiny ones
    MADE_FAR,       ///< the sheet far from the origin
    MADE_SHAPES
} made_shape;

enum { MADE_NORMALS = 1, MADE_COLORS = 2, MADE_TEXCOORDS = 4 };

/// About 2 side^2 triangles with the wanted attributes. False where memory runs out.
bool made_mesh_create(made_shape shape, uint32_t side, unsigned attributes, made_mesh* mesh);
void made_mesh_destroy(made_mesh* mesh);
/// In another order, each triangle turned.
void made_mesh_shuffle(made_mesh* mesh, uint64_t seed);
stp_store_mesh made_mesh_view(const made_mesh* mesh);
