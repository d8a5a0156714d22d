// SPDX-License-Identifier: MIT
//
// Triangles in the making, and the shapes that machines, houses and plants are made of. Everything is
// deterministic: no libm, so both compilers give the same bytes (scenes/trigonometry.h has sine and cosine).
//
// A builder that runs out of memory remembers it and ignores what follows: makers need not check each call.
#pragma once

#include "scene/scene.h"

typedef struct mesh_builder {
    stp_context* context;
    float* positions; ///< 3 a vertex
    float* normals;   ///< 3 a vertex
    uint32_t* indices;
    size_t vertex_count, index_count, vertex_capacity, index_capacity;
    bool failed;
    stp_affine
        place; ///< what follows is moved by it (rotation, uniform scale, translation); identity at first
} mesh_builder;

void mesh_builder_init(mesh_builder* builder, stp_context* context);
void mesh_builder_destroy(mesh_builder* builder);
/// @return the index of the vertex (0 after a failure)
uint32_t mesh_builder_vertex(mesh_builder* builder, stp_vec3 position, stp_vec3 normal);
void mesh_builder_triangle(mesh_builder* builder, uint32_t a, uint32_t b, uint32_t c);

/// Makes one mesh: fills the builder. `parameters` is the element of the batch. Runs inside jobs.
typedef void (*mesh_maker)(mesh_builder* builder, const void* parameters);

/// What a mesh is made of, and from what.
typedef struct mesh_recipe {
    const char* name; ///< static text, or of the scene's text arena; may be NULL
    mesh_maker make;
    const void* parameters; ///< valid until the batch is made
    uint32_t material;
} mesh_recipe;

/// Makes meshes on all threads and adds them to the scene in the order of the list, a few hundred at a time, so
/// that not all are in memory twice. `first_mesh` receives the index of the first.
STP_MUST_USE stp_result make_meshes(stp_scene* scene, const mesh_recipe* recipes, size_t count,
                                    uint32_t* first_mesh);
