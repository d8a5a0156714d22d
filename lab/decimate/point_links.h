// SPDX-License-Identifier: MIT
// Neighbour links of points, while points are merged.
#pragma once

#include "base/core/context.h"

typedef struct stp_point_links {
    stp_context* context;
    uint32_t count;           ///< number of points
    uint32_t* kept;           ///< per point, the point it was merged into; itself: none
    uint32_t *first, *last;   ///< per point: first and last entry of its list; UINT32_MAX: none
    uint32_t *targets, *next; ///< per entry: linked point, next entry; UINT32_MAX ends a list
    uint32_t* marks;          ///< per point: stamp of its last listing
    uint32_t stamp;
} stp_point_links;

/// Links two points if one is among the nearest of the other.
/// @param neighbours k per point, other points without repeats; UINT32_MAX if there are fewer
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged); freed by
///         stp_point_links_destroy, also after a failure
STP_MUST_USE stp_result stp_point_links_make(stp_context* context, const uint32_t* neighbours,
                                             uint32_t count, uint32_t k, stp_point_links* links);
/// Merges `gone` into `kept`, which takes its neighbours. Both must be unmerged.
void stp_point_links_unite(stp_point_links* links, uint32_t kept, uint32_t gone);
/// Lists the neighbours of an unmerged point, each once.
/// @param out space for all points.
/// @return number of neighbours
uint32_t stp_point_links_list(stp_point_links* links, uint32_t point, uint32_t* out);
void stp_point_links_destroy(stp_point_links* links);
