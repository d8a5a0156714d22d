// SPDX-License-Identifier: MIT
// The shadings that a splat's material byte refers to: the scene's materials without colour (which
// each splat has itself), reduced to at most 256.
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/blue/growths.h"
#include "scene/scene.h"

enum { STP_SHADING_LIMIT = 256 };

typedef struct stp_shading_set {
    uint32_t count; ///< at least 1
    stp_shading shadings[STP_SHADING_LIMIT];
    /// Index for each scene material, then for each of their variants (scene/looks.h); stp_free
    uint8_t* of_material;
    bool has_growths; ///< whether there is one for each growth of a point set's material
    stp_growth_table growths;
} stp_shading_set;

/// Exact if the used materials need at most 256 shadings. Then the content of a shading determines
/// its index, so it stays the same when others are added or removed, unless two collide; some
/// indices may be unused. Otherwise selects the 256 most different ones, and maps each material to
/// the nearest. Textures of metallic, roughness and emission count by their mean; the variants of a
/// material by their own values. With growths, materials of point sets have a further shading for
/// each, if all fit: first together with all variants, then without these, which take the shading
/// of their material. Reports progress.
/// @return STP_OK, STP_ERROR_CANCELLED or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_make_shadings(const stp_scene* scene, bool with_growths,
                                          stp_shading_set* set);
