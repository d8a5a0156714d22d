// SPDX-License-Identifier: MIT
// Which points are neighbours, while points become one.
#pragma once

#include "base/context.h"

typedef struct stp_point_links {
    stp_context* context;
    uint32_t count;           ///< of points
    uint32_t* kept;           ///< of a point, another one that it became; itself: none
    uint32_t *first, *last;   ///< entries of a point's list
    uint32_t *targets, *next; ///< of entries; next UINT32_MAX ends a list
    uint32_t* marks;          ///< of points: when they were last listed
    uint32_t stamp;
} stp_point_links;

/// Links points, where one is among the nearest of the other.
/// @param neighbours k a point, other points without repeats; UINT32_MAX where there are fewer
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged); freed by
///         stp_point_links_destroy, also after a failure
STP_MUST_USE stp_result stp_point_links_make(stp_context* context, const uint32_t* neighbours,
                                             uint32_t count, uint32_t k, stp_point_links* links);
/// `gone` becomes `kept`, which takes its neighbours. Both must be points that became no other.
void stp_point_links_unite(stp_point_links* links, uint32_t kept, uint32_t gone);
/// Lists the neighbours of a point that became no other, each once.
/// @param out room for all points. @return how many
uint32_t stp_point_links_list(stp_point_links* links, uint32_t point, uint32_t* out);
void stp_point_links_destroy(stp_point_links* links);
