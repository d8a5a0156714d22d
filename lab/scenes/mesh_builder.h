// SPDX-License-Identifier: MIT
//
// Builds meshes from vertices and triangles. Everything is deterministic: no functions of libm but
// the square root, so both compilers give the same bytes (lab/scenes/trigonometry.h has sine and
// cosine).
//
// A builder that runs out of memory records the failure and ignores further calls: makers need not
// check each call.
#pragma once

#include "scene/scene.h"

typedef struct mesh_builder {
    stp_context* context;
    float* positions; ///< 3 per vertex
    float* normals;   ///< 3 per vertex
    uint16_t* colors; ///< 4 per vertex, linear; NULL without mesh_builder_color
    uint32_t* indices;
    size_t vertex_count, index_count, vertex_capacity, index_capacity;
    uint16_t color[4]; ///< colour of the next vertices
    bool colored;
    bool flat;     ///< no normals: faces are flat and may share vertices at edges
    bool counting; ///< only counts, for plans
    bool failed;
    /// Placement of the next vertices (rotation, uniform scale, translation); initially identity
    stp_affine place;
} mesh_builder;

void mesh_builder_init(mesh_builder* builder, stp_context* context);
void mesh_builder_destroy(mesh_builder* builder);
/// Makes room for more vertices and indices. @return false if the builder has failed
bool mesh_builder_make_room(mesh_builder* builder, size_t vertices, size_t indices);
/// @return the index of the vertex (0 after a failure)
uint32_t mesh_builder_vertex(mesh_builder* builder, stp_vec3 position, stp_vec3 normal);
/// Sets the colour (linear, 0..1) of the next vertices. A mesh with colours must begin with this
/// call.
void mesh_builder_color(mesh_builder* builder, double red, double green, double blue);
void mesh_builder_triangle(mesh_builder* builder, uint32_t a, uint32_t b, uint32_t c);

/// Makes one mesh: fills the builder. `parameters` is the element of the batch. Runs inside jobs.
typedef void (*mesh_maker)(mesh_builder* builder, const void* parameters);

/// Maker and parameters of a mesh.
typedef struct mesh_recipe {
    const char* name; ///< static text, or of the scene's text arena; may be NULL
    mesh_maker make;
    const void* parameters; ///< valid until the batch is made
    uint32_t material;
} mesh_recipe;

/// Number of triangles of a recipe, without making them.
size_t count_triangles(mesh_maker make, const void* parameters);

/// Makes meshes on all threads and adds them to the scene in list order, in batches, so that not
/// all are in memory twice. `first_mesh` receives the index of the first.
STP_MUST_USE stp_result make_meshes(stp_scene* scene, const mesh_recipe* recipes, size_t count,
                                    uint32_t* first_mesh);
