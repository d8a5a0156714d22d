// SPDX-License-Identifier: MIT
// The graph of a scene and the sizes of its content, in one form for open files and for content to
// be written.
#pragma once

#include "store/file/block_order.h"
#include "store/file/content.h"
#include "store/file/store_state.h"

/// A mesh, point set, texture or splat set.
typedef struct stp_store_amount {
    uint64_t count, bytes; ///< triangles, points, texels or splats; bytes of its blocks
    uint32_t material;     ///< only for meshes and point sets
    uint32_t owner;        ///< only for textures: the first texture with this block
} stp_store_amount;

typedef struct stp_store_sizes {
    const stp_store_directory* directory;
    stp_store_amount *meshes, *point_sets, *textures, *sets;
} stp_store_sizes;

/// Sizes in an open file. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; nothing to destroy)
STP_MUST_USE stp_result stp_store_sizes_of_file(const stp_store* store, stp_store_sizes* sizes);
/// Sizes of content whose blocks are planned.
STP_MUST_USE stp_result stp_store_sizes_of_plan(stp_context* context,
                                                const stp_store_content* content,
                                                const stp_store_plan* plan, stp_store_sizes* sizes);
void stp_store_sizes_destroy(stp_context* context, stp_store_sizes* sizes);

/// As stp_store_summarise_content, for content whose blocks are planned.
STP_MUST_USE stp_result stp_store_summarise_planned(stp_context* context,
                                                    const stp_store_content* content,
                                                    const stp_store_plan* plan,
                                                    stp_store_summary* summary);

/// Makes a census from the table of objects, for scenes that come without one.
STP_MUST_USE stp_result stp_store_guess_census(stp_context* context,
                                               const stp_store_directory* directory,
                                               stp_store_census* census);

/// Computes all statistics of the whole scene and of the census's parts. Objects and instances come
/// from the census, or from the graph if `counted` is false.
STP_MUST_USE stp_result stp_store_count_figures(stp_context* context, const stp_store_sizes* sizes,
                                                const stp_store_census* census, bool counted,
                                                stp_store_summary* summary);

/// Compares the summary with the file's content.
STP_MUST_USE stp_result stp_store_check_summary(stp_store* store);
