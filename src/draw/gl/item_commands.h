// SPDX-License-Identifier: MIT
// Commands that draw the items of a list: clusters of meshes, and runs of splats.
#pragma once

#include "draw/gl/gl_renderer.h"
#include "raster/splat_groups.h"

// CPU culling of mesh clusters, and the drawn share of each.

/// Adds commands for the clusters of a placed mesh item that may be visible.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result stp_gl_cull_mesh(stp_gl_renderer* r, uint32_t index);

/// The same for an item of large triangles: adds commands for the clusters that contain some. The
/// shader skips the other triangles.
STP_MUST_USE stp_result stp_gl_cull_large(stp_gl_renderer* r, uint32_t index);

// Items of splat sets: uploads their octaves to the pool, and adds the commands that draw them.

/// Makes the item of a set from its resident part, with splats large enough for it.
/// @return STP_OK, or as uploads and the store's functions; logged
STP_MUST_USE stp_result stp_gl_set_item_make(stp_gl_renderer* r, uint32_t index);

// Commands that draw splats: one per run of a chunk, or several that skip invisible groups
// (raster/splat_groups.h).

/// The groups of an item in a view.
typedef struct stp_gl_splat_groups {
    const stp_splat_group* groups; ///< NULL: all splats are drawn
    uint32_t count;                ///< splats beyond these groups are always drawn
    stp_raster_groups view;
    bool beside; ///< omits splats that large triangles replace
} stp_gl_splat_groups;

/// Groups of a placed splat item, of which `octaves` are drawn.
/// @return STP_OK, or as stp_store_get_splat_set_prefix
STP_MUST_USE stp_result stp_gl_splat_groups_make(stp_gl_renderer* r, uint32_t index,
                                                 uint32_t octaves, stp_gl_splat_groups* groups);

/// Consecutive splats of an item in the pool.
typedef struct stp_gl_splat_chunk {
    uint32_t begin, end;            ///< index in the item
    uint32_t places, place_words;   ///< address of the first, and words per splat
    uint32_t options, option_words; ///< the same for shapes, ranges and errors
    bool of_materials;              ///< `options` is the address of materials, a byte each
    float reach;                    ///< maximum radius, relative to the item's
} stp_gl_splat_chunk;

/// Adds commands for a chunk. `groups`: NULL, or the item's. @return false if out of memory
STP_MUST_USE bool stp_gl_splat_commands_add(stp_gl_renderer* r, uint32_t index,
                                            const stp_gl_splat_chunk* chunk,
                                            const stp_gl_splat_groups* groups);
