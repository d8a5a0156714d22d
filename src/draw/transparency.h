// SPDX-License-Identifier: MIT
//
// Transparent surfaces of a scene, shared by both backends.
#pragma once

#include "draw/draw.h"
#include "select/select.h"
#include "store/file/store.h"

enum { STP_LAYERS_MAX = 64 }; ///< maximum layers per pixel; farther ones are left out

// Alphas of at least the first are opaque, below the second fully transparent (as capture rounds
// them to bytes).
#define STP_ALPHA_OPAQUE_FROM (254.5f / 255.0f)
#define STP_ALPHA_MIN (0.5f / 255.0f)
// Below this transmittance, farther layers are skipped.
#define STP_LAYERS_CLEAR (1.0f / 1024.0f)

/// Units of optical depth, whose sums are optical depths of several layers: half of the light
/// passes one. Whole numbers, so that sums do not depend on the order.
#define STP_OPTICAL_UNIT 4096
/// Optical depth of an opacity, below STP_ALPHA_OPAQUE_FROM; rounds it to a byte.
static inline uint32_t stp_optical_depth(float opacity)
{
    float byte = floorf(stp_clamp(opacity, 0.0f, 254.0f / 255.0f) * 255.0f + 0.5f);
    return (uint32_t)(-log2f(1.0f - byte * (1.0f / 255.0f)) * (float)STP_OPTICAL_UNIT + 0.5f);
}

/// Whether some triangles or splats of a scene may be transparent.
bool stp_transparency_of_scene(const stp_store_directory* directory);

/// Per splat shading (256 bytes): whether it is of a transparent material.
void stp_transparency_of_shadings(const stp_store_directory* directory, uint8_t transparent[256]);

/// Transparency of a mesh.
typedef enum stp_mesh_transparency {
    STP_TRANSPARENT_NOWHERE,    ///< opaque or cut out
    STP_TRANSPARENT_EVERYWHERE, ///< transparent everywhere
    STP_TRANSPARENT_PARTLY,     ///< parts may be opaque
} stp_mesh_transparency;

/// @param varies whether the material's alpha is multiplied by a texture or vertex colours
stp_mesh_transparency stp_transparency_of_mesh(const stp_store_material* material, bool varies);

/// Cells along an axis of a mesh's box, for the keys of its surfaces (raster/blue_noise.h).
#define STP_TRANSPARENT_CELLS 64.0f
/// Cells per unit of length of a mesh with this box.
float stp_transparency_cells(stp_box box);

/// Whether back-facing splats of an item can be culled. Sections, ghosts and transparent splats
/// (`glass`: the scene has some) show surface that faces away from the eye.
static inline bool stp_draw_one_sided(const stp_draw_item* item, bool glass)
{
    return item->one_sided && item->sections == 0 && !item->ghost && !glass;
}
