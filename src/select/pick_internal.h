// SPDX-License-Identifier: MIT
// Shared by the pick traversal and the tests of meshes and points.
#pragma once

#include "select/pick_ray.h"
#include "select/sections.h"
#include "store/file/store.h"

typedef struct stp_pick_work {
    stp_context* context;
    stp_store* store;
    const stp_store_directory* directory;
    const stp_pick_desc* desc;
    stp_pick* pick;
    double nearest;        ///< farther hits are ignored
    stp_vec3d across, off; ///< unit axes beside the ray's direction
} stp_pick_work;

/// Chooses the axes.
void stp_pick_begin(stp_pick_work* work);

/// Whether, and where, the ray hits a placed box before the current hit; the box is enlarged by
/// `wider` times half its diagonal. `points`: also by the reach of points.
bool stp_pick_enters(const stp_pick_work* work, const stp_affine* transform, const stp_boxd* box,
                     double wider, bool points, double* near);

/// Finds which edges of a triangle, in mesh space, lie within a flat face: another triangle of the
/// mesh shares the edge and the plane.
STP_MUST_USE stp_result stp_pick_find_inner(stp_pick_work* work, uint32_t mesh, uint32_t triangle,
                                            const stp_vec3 corners[3]);

/// Tests a mesh or point set. @return as stp_pick_ray
STP_MUST_USE stp_result stp_pick_part(stp_pick_work* work, stp_store_part part,
                                      const stp_affine* transform);

// Alpha masks: where triangles of cut-out and transparent materials let a ray pass.

/// Alpha test of a material.
typedef struct stp_pick_mask {
    bool asks; ///< otherwise triangles are solid
    const stp_store_material* material;
    stp_store_texture texture; ///< texture of the base colour; no texels: none
} stp_pick_mask;

/// A corner of a triangle.
typedef struct stp_pick_corner {
    stp_vec2 uv;
    float alpha; ///< alpha of its colour; 1 without colours
} stp_pick_corner;

/// `colors`: whether corners have colours. Borrows the store's texels. @return as
/// stp_store_get_texture
STP_MUST_USE stp_result stp_pick_mask_make(stp_store* store, const stp_store_material* material,
                                           bool colors, stp_pick_mask* mask);

/// Whether a triangle is solid at a position: cut-out materials if alpha reaches the cutoff,
/// transparent ones unless alpha is 0. `share`: barycentric coordinates.
bool stp_pick_mask_has(const stp_pick_mask* mask, const stp_pick_corner corners[3],
                       const double share[3]);
