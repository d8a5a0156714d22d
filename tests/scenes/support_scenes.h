// SPDX-License-Identifier: MIT
// What tests of named scenes share.
#pragma once

#include "tests.h"

#include "scenes/scenes.h"

/// A scene's figures as Table 1 has them (Brandt et al. 2019): an object is a mesh in its place.
typedef struct scene_sums {
    uint64_t objects, unique_objects, triangles, unique_triangles;
} scene_sums;

/// Of a scene that stp_scene_finish has seen.
scene_sums sum_scene(const stp_scene* scene);

/// Makes and finishes a scene; NULL where that fails.
stp_scene* make_scene(stp_context* context, const char* name, double scale, uint64_t seed);

/// Of all bytes of meshes, objects, instances and views.
stp_hash hash_scene(const stp_scene* scene);
