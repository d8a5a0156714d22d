// SPDX-License-Identifier: MIT
// Scenes with levels of triangles, built into files.
#pragma once

#include "builder/build_scene.h"
#include "store/file/store.h"

/// Adds the content of a scene. @return false if out of memory
typedef bool level_scene(stp_scene* scene);

typedef struct level_build {
    level_scene* make;
    bool no_splats, no_levels, coarse, fresh;
    uint32_t leaf_triangles; ///< 0: the default
} level_build;

stp_result level_build_to(stp_context* context, const level_build* build, const char* path,
                          stp_build_report* report);
/// Builds into a temporary file, and opens it. NULL on failure.
stp_store* level_build_open(stp_context* context, const level_build* build);

/// A red torus of 20,000 triangles around the y axis, of radii 1 and 0.4.
bool level_scene_torus(stp_scene* scene);
/// A ball of radius 1, open at its top (+y), with a blue torus inside.
bool level_scene_open_ball(stp_scene* scene);
/// Two such tori, side by side along x.
bool level_scene_two_tori(stp_scene* scene);
/// A sheet of 20,000 triangles from 0 to 1 in x and z, with waves of a height of 0.02.
bool level_scene_sheet(stp_scene* scene);
/// Adds a sheet of cells * cells squares from -1 to 1 in the plane z = 0, facing +z; the first row of
/// its material's textures is at the top.
bool level_scene_add_textured_sheet(stp_scene* scene, uint32_t cells, uint32_t material);
/// Adds 24 uses of meshes 0 and 1, which are prototypes already, on a grid of 5 columns.
bool level_scene_add_copies(stp_scene* scene);
/// Many copies of two tori.
bool level_scene_copies(stp_scene* scene);
