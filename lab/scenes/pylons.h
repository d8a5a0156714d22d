// SPDX-License-Identifier: MIT
//
// Power lines across the terrain. The totals in Table 1 of Brandt et al. 2019 exceed the sum of its
// rows by 305 objects, one unique mesh and some 60,000 unique triangles: here, the pylons account
// for those.
#pragma once

#include "lab/scenes/scenes.h"

STP_MUST_USE stp_result scene_add_pylons(stp_scene* scene, uint32_t parent,
                                         const scene_options* options);
/// Makes one lattice tower, 42 m tall (a mesh_maker without parameters).
struct mesh_builder;
void pylon_make(struct mesh_builder* builder, const void* parameters);
