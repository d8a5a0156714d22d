// SPDX-License-Identifier: MIT
//
// The looks of materials whose roughness, metal or emission come from textures. Splats name one of
// at most 256 shadings, so the values of texels are put into bins, and each combination of bins is
// a variant of the material: material_count + variant counts as one more material.
#pragma once

#include "scene/scene.h"

enum {
    STP_LOOK_CODES = 64,    ///< of one texel
    STP_LOOK_VARIANTS = 64, ///< of one material, at most
};

/// The values that texels of one texture have.
struct stp_look_bins {
    uint32_t count;                  ///< at least 1
    uint8_t of_code[STP_LOOK_CODES]; ///< the bin of each code
    /// The mean of each bin's texels. Of a surface: metal, roughness. Of a glow: red, green, blue,
    /// linear. All 0 to 1, to be multiplied by the factors of the material.
    float values[STP_LOOK_CODES][3];
    uint32_t steps; ///< of each channel; codes are made of these
};

struct stp_look {
    uint32_t material, first_variant;
    uint32_t surface, glow; ///< indices in scene->look_bins, which looks share; 0: no texture
};

/// What a variant looks like, in place of the means of its material's textures.
typedef struct stp_variant {
    uint32_t material;
    float metallic, roughness, emissive[3];
} stp_variant;

/// Finds the looks of all materials that triangles have, from their texels: scene->looks,
/// scene->look_bins and scene->variant_count, once the scene is finished. Reports progress.
/// @return STP_OK, STP_ERROR_CANCELLED, STP_ERROR_LIMIT or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_find_looks(stp_scene* scene);

static inline const stp_look_bins* stp_look_surface(const stp_scene* scene, const stp_look* look)
{
    return &scene->look_bins[look->surface];
}

static inline const stp_look_bins* stp_look_glow(const stp_scene* scene, const stp_look* look)
{
    return &scene->look_bins[look->glow];
}

/// Variants of a look; 1: its material has none.
static inline uint32_t stp_look_variants(const stp_scene* scene, const stp_look* look)
{
    return stp_look_surface(scene, look)->count * stp_look_glow(scene, look)->count;
}

/// Bin of a surface by values of 0 to 1.
uint32_t stp_look_surface_bin(const stp_look_bins* surface, float metal, float roughness);
/// Bin of a glow by linear values of 0 to 1.
uint32_t stp_look_glow_bin(const stp_look_bins* glow, const float color[3]);

/// The material index that stands for a variant.
static inline uint32_t stp_look_index(const stp_scene* scene, const stp_look* look,
                                      uint32_t surface, uint32_t glow)
{
    return (uint32_t)scene->material_count + look->first_variant +
           surface * stp_look_glow(scene, look)->count + glow;
}

/// @param variant below scene->variant_count
stp_variant stp_scene_get_variant(const stp_scene* scene, uint32_t variant);
