// SPDX-License-Identifier: MIT
// Smooth shapes of thousands of triangles, for tests of their levels.
#pragma once

#include "scene/scene.h"

/// A torus around the y axis, closed; fronts outward. `wide`: radius of its middle circle, `thick`:
/// of the tube, which has small waves. 2 * around * across triangles.
stp_mesh level_torus(stp_context* context, uint32_t around, uint32_t across, double wide,
                     double thick);
/// A ball around the origin, fronts outward; `open` rows around its top (+y) are left out.
/// 2 * columns * (rows - open) triangles, those at the poles degenerate.
stp_mesh level_ball(stp_context* context, uint32_t columns, uint32_t rows, uint32_t open,
                    double radius);
/// A sheet from 0 to `width` in x and z, fronts up (+y); `bump`: height of its waves.
/// 2 * side * side triangles; vertex (x, z) has the number z * (side + 1) + x.
stp_mesh level_sheet(stp_context* context, uint32_t side, double width, double bump);

/// Adds an opaque, rough material. @return its index; STP_NONE if out of memory
uint32_t level_add_material(stp_scene* scene, float red, float green, float blue);

/// Adds a mesh of a material, and an object that shows it. @return the mesh's index; STP_NONE if out
/// of memory
uint32_t level_add(stp_scene* scene, stp_mesh mesh, uint32_t material, stp_affine place);
