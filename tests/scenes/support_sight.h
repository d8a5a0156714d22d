// SPDX-License-Identifier: MIT
// Rays through a scene, by brute force over triangles: tests whether an eye is inside a solid.
#pragma once

#include "tests.h"

#include "scene/scene.h"

typedef struct sight {
    const stp_scene* scene; ///< finished
    stp_placed_part* parts;
    stp_boxd* boxes; ///< bounding box of each part, in scene space
    size_t part_count;
} sight;

typedef struct sight_hit {
    double distance; ///< in lengths of the direction; INFINITY: no hit
    bool from_behind;
} sight_hit;

/// @return false on failure
bool sight_open(sight* s, const stp_scene* scene);
void sight_close(sight* s);

/// The nearest triangle that a ray hits.
sight_hit sight_look(const sight* s, stp_vec3d eye, stp_vec3d direction);

/// Whether the first triangle above is hit from behind, and so is the first below, or there is
/// none: inside a solid. `ground`: the scene has a floor, so a point without anything below lies
/// under it.
bool sight_is_inside(const sight* s, bool ground, stp_vec3d eye);
