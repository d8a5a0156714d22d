// SPDX-License-Identifier: MIT
// Small scenes for tests and benchmarks; see scene_recipes().
#pragma once

#include "lab/scenes/scenes.h"

stp_result scene_make_boxes(stp_scene* scene, const scene_options* options);
stp_result scene_make_spheres(stp_scene* scene, const scene_options* options);
stp_result scene_make_one_mesh(stp_scene* scene, const scene_options* options);
stp_result scene_make_forest(stp_scene* scene, const scene_options* options);
stp_result scene_make_terrain(stp_scene* scene, const scene_options* options);
stp_result scene_make_city(stp_scene* scene, const scene_options* options);
stp_result scene_make_small_city(stp_scene* scene, const scene_options* options);
