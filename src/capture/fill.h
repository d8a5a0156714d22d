// SPDX-License-Identifier: MIT
//
// Fills in surface that the main directions of a capture miss: grooves between fins, the inside of
// a bracket, the ground under a table. It is visible from outside, but not from the eight corners.
// So the object is also drawn from further directions (the middles of faces and edges). From these
// pictures only surface without an existing candidate is kept: none within a pixel's size that
// faces the further direction too. Surface that the main directions sampled thinly, at grazing
// angles, is filled up the same way.
//
// No search is needed: such a candidate lies in one of the four pixels around the place where a
// main view shows the point. So each pixel of a further view costs a projection or two.
#pragma once

#include "capture/capture_internal.h"

enum { STP_CAPTURE_FILL_DIRECTIONS = 26 /**< a cube's corners, faces and edges */ };

/// 32 pixels of a row.
typedef struct stp_fill_word {
    uint32_t covered;
    uint32_t first; ///< candidate of the first covered pixel
} stp_fill_word;

/// Surface shown by a pixel.
typedef struct stp_fill_surface {
    float nearness;
    uint32_t normal; ///< three signed numbers of ten bits, x lowest; 511 is 1
} stp_fill_surface;

/// Surface shown by each pixel of the main views.
typedef struct stp_fill_map {
    const stp_capture_view* views;
    uint32_t view_count; ///< fewer than STP_CAPTURE_FILL_DIRECTIONS
    double pixel_size;   ///< distance within which one candidate represents another
    stp_fill_word* words;
    stp_fill_surface* surface; ///< one per candidate
    uint64_t* points; ///< one bit per primitive: points that are candidates; NULL: no points
    size_t starts[STP_CAPTURE_FILL_DIRECTIONS]; ///< first word of each view
} stp_fill_map;

/// Creates the map from the job's bands, whose pixels will become candidates 0 and up.
STP_MUST_USE stp_result stp_fill_map_create(const stp_capture_job* job,
                                            const stp_candidates* candidates, stp_fill_map* map);
/// Stores the surface of each candidate, once the candidates exist.
void stp_fill_map_set_surface(stp_context* context, stp_fill_map* map,
                              const stp_candidates* candidates);
void stp_fill_map_destroy(stp_context* context, stp_fill_map* map);

/// Whether a point is already a candidate. A point may lie anywhere in its pixel, so its position
/// does not tell.
static inline bool stp_fill_knows_point(const stp_fill_map* map, uint64_t primitive)
{
    return map->points != NULL && (map->points[primitive / 64] >> primitive % 64 & 1) != 0;
}

/// Empties the pixels of a band that existing candidates represent.
void stp_fill_drop_known(const stp_fill_map* map, const stp_capture_view* view, uint32_t first_row,
                         const stp_raster_target* target);

/// Draws the further views and appends their surface to the candidates, which must be those of the
/// map.
STP_MUST_USE stp_result stp_capture_fill(stp_capture_job* job, const stp_fill_map* map,
                                         stp_candidates* candidates);
