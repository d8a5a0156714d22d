// SPDX-License-Identifier: MIT
// Where triangles of cut-out and transparent materials are not there, so that a ray goes on to what is behind.
#pragma once

#include "store/store.h"

/// What a material's alpha asks of its triangles.
typedef struct stp_pick_mask {
    bool asks; ///< else triangles are there wherever they are
    const stp_store_material* material;
    stp_store_texture texture; ///< of the base colour; no texels: none
} stp_pick_mask;

/// A corner of a triangle.
typedef struct stp_pick_corner {
    stp_vec2 uv;
    float alpha; ///< of its colour; 1 where it has none
} stp_pick_corner;

/// `colors`: corners have colours. Borrows the store's texels. @return as stp_store_get_texture
STP_MUST_USE stp_result stp_pick_mask_make(stp_store* store, const stp_store_material* material,
                                           bool colors, stp_pick_mask* mask);

/// Whether a triangle is there: cut-out where alpha reaches the cutoff, transparent where it is not wholly so. `share`: of
/// the corners, 1 in all.
bool stp_pick_mask_has(const stp_pick_mask* mask, const stp_pick_corner corners[3],
                       const double share[3]);
