// SPDX-License-Identifier: MIT
// Alpha masks: where triangles of cut-out and transparent materials let a ray pass.
#pragma once

#include "store/file/store.h"

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
