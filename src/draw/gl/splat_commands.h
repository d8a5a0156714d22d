// SPDX-License-Identifier: MIT
// Commands that draw splats: one per run of a chunk, or several that skip invisible groups
// (raster/splat_groups.h).
#pragma once

#include "draw/gl/gl_renderer.h"
#include "raster/splat_groups.h"

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
    uint32_t options, option_words; ///< the same for shapes and ranges
    float reach;                    ///< maximum radius, relative to the item's
} stp_gl_splat_chunk;

/// Adds commands for a chunk. `groups`: NULL, or the item's. @return false if out of memory
STP_MUST_USE bool stp_gl_splat_commands_add(stp_gl_renderer* r, uint32_t index,
                                            const stp_gl_splat_chunk* chunk,
                                            const stp_gl_splat_groups* groups);
