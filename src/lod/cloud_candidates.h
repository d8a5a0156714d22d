// SPDX-License-Identifier: MIT
// Candidates of a point cloud, which needs no capture: its points, with normals from their
// neighbours, or the splats that represent them.
#pragma once

#include "lod/cell_rows.h"
#include "lod/sources.h"

/// Turns every point of a list's point sets, and every splat of its splat sets, into a candidate,
/// hidden or not. `pixel_size` stays 0.
/// @param has_normals takes normals from the point sets; otherwise sets (0, 1, 0), to be estimated
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_candidates_of_cloud(const stp_scene* scene, const stp_source_list* list,
                                                bool has_normals, stp_candidates* candidates);

/// Whether all point sets of a list have normals.
bool stp_sources_have_normals(const stp_scene* scene, const stp_source_list* list);

// Normals of point clouds without normals: the direction of least spread among neighbours (Hoppe et
// al. Surface Reconstruction from Unorganized Points. 1992). They face up rather than down; which
// side is outside is not determined.

/// Estimates normals of candidates that are points from the candidates within `radius`. With fewer
/// than four, including the point itself, or with neighbours in a line, as along the ring of a
/// scanner, doubles the radius up to four times. If that does not help, a line's points keep their
/// first normal, and that of others is straight up. Splats of sets keep their normals. Does nothing
/// if the radius is 0.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                                   float radius);

/// What is known of a candidate's normal.
enum {
    STP_NORMAL_KNOWN,
    STP_NORMAL_NONE,    ///< too few neighbours
    STP_NORMAL_OF_LINE, ///< it is a normal of the line of the neighbours, not of their plane
};

/// The same in two steps, for callers that know better normals of points with few neighbours.
typedef struct stp_normal_search {
    stp_context* context;
    stp_candidates* candidates;
    uint8_t* missing; ///< one of these per candidate; the caller may set STP_NORMAL_KNOWN
    float radius;
    stp_cell_rows rows; ///< the candidates, in cells slightly wider than `radius`
} stp_normal_search;

/// Estimates normals within `radius`, which is above 0.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_normal_search_destroy, also after
///         a failure
STP_MUST_USE stp_result stp_normal_search_start(stp_context* context, stp_candidates* candidates,
                                                float radius, stp_normal_search* search);
/// Estimates the normals that are missing.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_normal_search_finish(stp_normal_search* search);
void stp_normal_search_destroy(stp_normal_search* search);
