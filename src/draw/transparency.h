// SPDX-License-Identifier: MIT
//
// What is transparent in a scene: what both backends ask in the same way.
#pragma once

#include "draw/draw.h"
#include "store/store.h"

enum { STP_LAYERS_MOST = 64 }; ///< layers of a pixel that are told apart; those behind are left out

// Alphas of at least the first are opaque, of less than the second they are not there (as capture rounds them to bytes).
#define STP_ALPHA_OPAQUE_FROM (254.5f / 255.0f)
#define STP_ALPHA_LEAST (0.5f / 255.0f)
// Where less light than this gets through, layers behind are not looked for.
#define STP_LAYERS_CLEAR (1.0f / 1024.0f)

/// Whether some triangles or splats of a scene may be transparent.
bool stp_transparency_of_scene(const stp_store_directory* directory);

/// For each shading of surfels (256 bytes): whether it is that of a transparent material.
void stp_transparency_of_shadings(const stp_store_directory* directory, uint8_t transparent[256]);

/// How transparent a mesh is.
typedef enum stp_mesh_glass {
    STP_GLASS_NONE, ///< opaque or cut out
    STP_GLASS_ALL,  ///< everywhere
    STP_GLASS_SOME, ///< some of it may be opaque
} stp_mesh_glass;

/// @param varies whether a texture or colours of vertices are multiplied by the material's alpha
stp_mesh_glass stp_transparency_of_mesh(const stp_store_material* material, bool varies);

/// Cells along an axis of a mesh's box, for the keys of its surfaces (raster/blue_noise.h).
#define STP_GLASS_CELLS 64.0f
/// Cells in a unit of length of a mesh with this box.
float stp_transparency_cells(stp_box box);
