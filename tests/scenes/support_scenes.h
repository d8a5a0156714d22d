// SPDX-License-Identifier: MIT
// Shared by the tests of named scenes.
#pragma once

#include "tests.h"

#include "lab/scenes/scenes.h"

/// A scene's figures as in Table 1 of Brandt et al. 2019: an object is a placed mesh.
typedef struct scene_sums {
    uint64_t objects, unique_objects, triangles, unique_triangles;
} scene_sums;

/// Sums over a finished scene (stp_scene_finish).
scene_sums sum_scene(const stp_scene* scene);

/// Makes and finishes a scene; NULL on failure.
stp_scene* make_scene(stp_context* context, const char* name, double scale, uint64_t seed);

/// Hash of all meshes, base colours of materials, objects and instances.
stp_hash hash_scene(const stp_scene* scene);
