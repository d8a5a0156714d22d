// SPDX-License-Identifier: MIT
// What a mesh looks like before anything was made of it: a few of its points, to be seen within moments.
#pragma once

#include "scene/scene.h"
#include "store/store.h"

/// So many points of a mesh's triangles, spread by area, with normals of their faces and with the colours of
/// vertices and texture (where texels lie in the scene). What a cut-out cuts away has none, so there may be fewer.
/// The same every time. Arrays are the arena's. @return false where memory runs out
bool stp_preview_mesh(stp_arena* arena, const stp_scene* scene, uint32_t mesh, uint32_t count,
                      stp_store_point_set* points);

/// At most so many of a point set's points, spread over it; all of them where they are no more.
bool stp_preview_points(stp_arena* arena, const stp_point_set* from, uint32_t count,
                        stp_store_point_set* points);
