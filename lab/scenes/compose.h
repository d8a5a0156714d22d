// SPDX-License-Identifier: MIT
// Small helpers that put a scene together.
#pragma once

#include "lab/scenes/scenes.h"

stp_affine place_at(double x, double y, double z);
/// Rotates about the vertical axis by a fraction of a turn, scales, then moves.
stp_affine place_turned(double x, double y, double z, double turns, double scale);

/// An opaque non-metal material; colours as sRGB, 0xRRGGBB.
STP_MUST_USE stp_result add_plain_material(stp_scene* scene, const char* name, uint32_t srgb,
                                           double roughness, uint32_t* index);
/// An object that contains others.
STP_MUST_USE stp_result add_group(stp_scene* scene, const char* name, uint32_t parent,
                                  const stp_affine* transform, uint32_t* index);
/// An object that shows one mesh.
STP_MUST_USE stp_result add_mesh_object(stp_scene* scene, const char* name, uint32_t parent,
                                        const stp_affine* transform, uint32_t mesh);
STP_MUST_USE stp_result add_view(stp_scene* scene, const char* name, stp_vec3d eye,
                                 stp_vec3d target, double fov_degrees);

// Small scenes for tests and benchmarks; see scene_recipes().

stp_result scene_make_boxes(stp_scene* scene, const scene_options* options);
stp_result scene_make_spheres(stp_scene* scene, const scene_options* options);
stp_result scene_make_one_mesh(stp_scene* scene, const scene_options* options);
stp_result scene_make_forest(stp_scene* scene, const scene_options* options);
stp_result scene_make_terrain(stp_scene* scene, const scene_options* options);
stp_result scene_make_city(stp_scene* scene, const scene_options* options);
stp_result scene_make_small_city(stp_scene* scene, const scene_options* options);
