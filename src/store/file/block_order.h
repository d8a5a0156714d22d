// SPDX-License-Identifier: MIT
// The order of the blocks in a file: coarse to fine, across the whole scene.
#pragma once

#include "store/bytes/format.h"
#include "store/file/content.h"

typedef struct stp_store_plan {
    stp_store_block* blocks; ///< in file order; checksums are 0 until written
    uint32_t block_count;
    // the block of each mesh, point set and texture, and of each octave of each set in order
    uint32_t* mesh_blocks;
    uint32_t* point_blocks;
    uint32_t* texture_blocks; ///< equal for textures that share a picture
    uint32_t* octave_blocks;
    uint32_t* leaf_blocks;    ///< per set; STP_STORE_NONE: no leaves
    uint32_t attribute_count; ///< number of attribute blocks
    uint64_t file_bytes;
} stp_store_plan;

/// Places all blocks from `data_offset` on. @return STP_OK, OUT_OF_MEMORY or LIMIT (too many
/// blocks)
STP_MUST_USE stp_result stp_store_plan_make(stp_context* context, const stp_store_content* content,
                                            uint64_t data_offset, stp_store_plan* plan);
void stp_store_plan_destroy(stp_context* context, stp_store_plan* plan);

/// The coded mesh; NULL if the mesh is written as floats.
const stp_coded_mesh* stp_store_coded_mesh(const stp_store_content* content, uint32_t index);

/// Bit mask of the optional columns.
uint32_t stp_store_mesh_present(const stp_store_mesh* mesh);
uint32_t stp_store_points_present(const stp_store_point_set* points);
/// Bit mask of the attributes in an attribute block.
uint32_t stp_store_planned_attributes(const stp_store_content* content,
                                      const stp_store_block* block);
