// SPDX-License-Identifier: MIT
// Rays through a scene, triangle by triangle: what stands before an eye, and whether it is inside of something.
#pragma once

#include "tests.h"

#include "scene/scene.h"

typedef struct sight {
    const stp_scene* scene; ///< finished
    stp_placed_part* parts;
    stp_boxd* boxes; ///< of each part, in scene space
    size_t part_count;
} sight;

typedef struct sight_hit {
    double distance; ///< in lengths of the direction; INFINITY: nothing is hit
    bool from_behind;
} sight_hit;

/// @return false where that fails
bool sight_open(sight* s, const stp_scene* scene);
void sight_close(sight* s);

/// The nearest triangle that a ray hits.
sight_hit sight_look(const sight* s, stp_vec3d eye, stp_vec3d direction);

/// Whether the first thing above is seen from behind, and the first below, too, or there is none: inside of what is
/// solid. `ground`: and below all else lies a floor, so that who has nothing below is under it.
bool sight_is_inside(const sight* s, bool ground, stp_vec3d eye);
