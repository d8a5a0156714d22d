// SPDX-License-Identifier: MIT
// What a surfel's material byte stands for: the scene's materials, without what each surfel has itself (its
// colour), reduced to at most 256.
#pragma once

#include "scene/scene.h"

#include <stipple/surfels.h>

enum { STP_SHADING_LIMIT = 256 };

typedef struct stp_shading_set {
    uint32_t count; ///< at least 1
    stp_shading shadings[STP_SHADING_LIMIT];
    uint8_t* of_material; ///< for each scene material (stp_free)
} stp_shading_set;

/// Exact where the used materials need at most 256: the index of each is then told by its content, so that it
/// stays the same when others come and go (but where two want the same index); indices between may be nobody's. Else 256 that differ most, and the nearest of them for
/// each material. Textures of metallic, roughness and emission count by their mean.
STP_MUST_USE stp_result stp_make_shadings(const stp_scene* scene, stp_shading_set* set);
