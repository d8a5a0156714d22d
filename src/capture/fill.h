// SPDX-License-Identifier: MIT
//
// What the directions of a capture miss. Grooves between fins, the inside of a bracket, the ground under a
// table: they are visible from outside, but not from the eight corners. So the object is drawn from further
// directions too (the middles of faces and edges), and of these pictures only that surface is kept which no
// candidate of the first ones stands for: none within a pixel's size that faces the further direction too.
// Surface that the first directions saw at a slant, and sampled thinly, is filled up likewise.
//
// Nothing is searched for: a candidate that near lies in one of the four pixels around the place where a first
// view shows the point. So a pixel of a further view costs a projection or two, and becomes a candidate only
// where nothing was found.
#pragma once

#include "capture/capture_internal.h"

enum { STP_CAPTURE_FILL_DIRECTIONS = 26 /**< a cube's corners, faces and edges */ };

/// 32 pixels of a row.
typedef struct stp_fill_word {
    uint32_t covered;
    uint32_t first; ///< candidate of the first covered one
} stp_fill_word;

/// The surface that a pixel shows.
typedef struct stp_fill_surface {
    float nearness;
    uint32_t normal; ///< three signed numbers of ten bits, x lowest; 511 is 1
} stp_fill_surface;

/// What each pixel of the first views shows.
typedef struct stp_fill_map {
    const stp_capture_view* views;
    uint32_t view_count; ///< fewer than STP_CAPTURE_FILL_DIRECTIONS
    double pixel_size;   ///< the distance within which a candidate stands for another
    stp_fill_word* words;
    stp_fill_surface* surface; ///< of each candidate
    uint64_t* points; ///< a bit a primitive: points that are candidates; NULL: there are no points
    size_t starts[STP_CAPTURE_FILL_DIRECTIONS]; ///< of each view in `words`
} stp_fill_map;

/// Of the job's bands, whose pixels will be the candidates from 0 on.
STP_MUST_USE stp_result stp_fill_map_create(const stp_capture_job* job,
                                            const stp_candidates* candidates, stp_fill_map* map);
/// Once they are.
void stp_fill_map_set_surface(stp_context* context, stp_fill_map* map,
                              const stp_candidates* candidates);
void stp_fill_map_destroy(stp_context* context, stp_fill_map* map);

/// Whether a point is a candidate already. It lies anywhere in its pixel, so its place does not tell.
static inline bool stp_fill_knows_point(const stp_fill_map* map, uint64_t primitive)
{
    return map->points != NULL && (map->points[primitive / 64] >> primitive % 64 & 1) != 0;
}

/// Empties the pixels of a band that candidates of the map stand for.
void stp_fill_drop_known(const stp_fill_map* map, const stp_capture_view* view, uint32_t first_row,
                         const stp_raster_target* target);

/// Draws the further views, and appends what they see to the candidates, which are those of the map.
STP_MUST_USE stp_result stp_capture_fill(stp_capture_job* job, const stp_fill_map* map,
                                         stp_candidates* candidates);
