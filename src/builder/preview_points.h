// SPDX-License-Identifier: MIT
// A quick preview of a mesh or point set: a few of its points, before anything else is made from
// it.
#pragma once

#include "scene/scene.h"
#include "store/file/store.h"

/// Makes `count` points on a mesh's triangles, spread by area, with face normals and the colours of
/// vertices and texture (if the scene has texels). Cut-out areas get none, so there may be fewer.
/// Deterministic. The arena owns the arrays. @return false if memory runs out
bool stp_preview_mesh(stp_arena* arena, const stp_scene* scene, uint32_t mesh, uint32_t count,
                      stp_store_point_set* points);

/// At most `count` of a point set's points with their attributes, spread over it; all of them if
/// there are no more.
bool stp_preview_points(stp_arena* arena, const stp_point_set* from, uint32_t count,
                        stp_store_point_set* points);
