// SPDX-License-Identifier: MIT
// Commands that draw splats: one for each run of a chunk, or several, which leave out groups that cannot be seen
// (raster/splat_groups.h).
#pragma once

#include "draw/gl/renderer.h"
#include "raster/splat_groups.h"

/// The groups of an item in a view.
typedef struct gl_splat_groups {
    const stp_splat_group* groups; ///< NULL: all splats are drawn
    uint32_t count;                ///< splats beyond these groups are drawn
    stp_raster_groups view;
    bool beside; ///< splats that large triangles replace are left out
} gl_splat_groups;

/// Groups of a surfel item, of which `octaves` are drawn; it is placed.
/// @return STP_OK, or as stp_store_get_surfels_prefix
STP_MUST_USE stp_result gl_splat_groups_make(gl_renderer* r, uint32_t index, uint32_t octaves,
                                             gl_splat_groups* groups);

/// Splats of an item that lie together in the pool.
typedef struct gl_splat_chunk {
    uint32_t begin, end;            ///< in the item
    uint32_t places, place_words;   ///< address of the first, and words of each
    uint32_t options, option_words; ///< the same of shapes and ranges
    float reach;                    ///< the largest radius, in those of the item
} gl_splat_chunk;

/// Adds commands for a chunk. `groups`: NULL, or the item's. @return false where memory runs out
STP_MUST_USE bool gl_splat_commands_add(gl_renderer* r, uint32_t index, const gl_splat_chunk* chunk,
                                        const gl_splat_groups* groups);
