// SPDX-License-Identifier: MIT
// Difficult meshes for the cluster coder.
#pragma once

#include "store/clusters/clusters.h"

#include <stdbool.h>

/// Like stp_store_mesh, but writable. The made mesh owns the arrays.
typedef struct made_mesh {
    uint32_t vertex_count, triangle_count;
    float* positions;
    int16_t* normals;
    float* texcoords[2];
    uint16_t* colors;
    uint32_t* indices;
} made_mesh;

typedef enum made_shape {
    MADE_WAVE,      ///< a smooth sheet with shared vertices
    MADE_SOUP,      ///< the same, without shared vertices
    MADE_SCATTERED, ///< unconnected triangles in random places
    MADE_BOXES,     ///< hard edges: four vertices per face
    MADE_SLIVERS,   ///< the sheet, a thousand times longer than wide, with degenerate triangles
    MADE_UNEVEN,    ///< one huge triangle over a sheet of tiny ones
    MADE_FAR,       ///< the sheet far from the origin
    MADE_SHAPES
} made_shape;

enum { MADE_NORMALS = 1, MADE_COLORS = 2, MADE_TEXCOORDS = 4 };

/// About 2 side^2 triangles with the requested attributes. False if memory runs out.
bool made_mesh_create(made_shape shape, uint32_t side, unsigned attributes, made_mesh* mesh);
void made_mesh_destroy(made_mesh* mesh);
/// Shuffles the triangles and rotates each one's corners.
void made_mesh_shuffle(made_mesh* mesh, uint64_t seed);
stp_store_mesh made_mesh_view(const made_mesh* mesh);
