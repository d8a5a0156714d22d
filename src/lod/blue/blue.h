// SPDX-License-Identifier: MIT
//
// Method `blue`: Progressive Blue Surfels (Brandt et al. 2019). Candidates are captured, ordered,
// and finished into surfels: columns, prefix table, colour pyramid, coverage.
#pragma once

#include "base/splats/splat_columns.h"
#include "capture/capture.h"
#include "lod/blue/growths.h"
#include "lod/set_columns.h"

#include <stipple/order.h>

typedef struct stp_blue_desc {
    stp_capture_desc capture;
    stp_order_desc order;
    /// Splats of the set, if there are as many candidates; 0: by the default stp_splat_rule, or all
    /// points of a cloud
    uint32_t splat_count;
    /// Existing sets of the nodes below, by scene node: NULL or a set of count 0 if there is none.
    /// If a set is dense enough, its splats are captured instead of triangles (Brandt 3.4;
    /// docs/algorithms/capture.md, Capture of upper nodes), and the visible splats themselves
    /// become candidates. NULL: always triangles.
    const stp_splats* const* sets;
    const stp_growth_table* growths; ///< shadings of points with each growth; NULL: none
} stp_blue_desc;

/// How many splats the set of a node gets. Brandt 5.2 takes one for 2 triangles, at most 200,000;
/// the last three quarters of those are never worth drawing (docs/notes/2026-11-proportion.md).
typedef struct stp_splat_rule {
    double ratio;     ///< one splat for so many triangles and points; 0: STP_TRIANGLES_PER_SPLAT
    uint32_t maximum; ///< of one set; 0: 50,000
} stp_splat_rule;

/// Splats for a node with so many triangles and points below it, at least 1.
uint64_t stp_splat_rule_count(const stp_splat_rule* rule, uint64_t triangles, uint64_t points);

typedef struct stp_blue_report {
    double capture_ms, order_ms, finish_ms;
    uint32_t candidate_count;
    size_t source_sets; ///< number of lower sets that candidates were taken from
} stp_blue_report;

/// Makes the surfels of everything below a scene node, except moving parts. `materials` of the
/// result index scene materials reduced to at most 256 shadings by `shading_of_material` (one byte
/// per scene material). A scene of points only is not captured: its points are the candidates, and
/// by default all of them become surfels. Arrays of the result come from stp_alloc; `count` is 0 if
/// nothing is visible. `report` may be NULL.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT, STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_blue_make(const stp_scene* scene, uint32_t node,
                                      const uint8_t* shading_of_material, const stp_blue_desc* desc,
                                      stp_splats* surfels, stp_blue_report* report);

/// Candidates from which the splats of a node are chosen.
typedef struct stp_blue_candidates {
    stp_candidates candidates;
    uint32_t wanted; ///< number to choose
    bool from_points;
    bool two_sided; ///< points without normals, which are to be estimated
} stp_blue_candidates;

/// Finds the candidates of everything below a node, as stp_blue_make does; none if nothing is
/// visible.
/// @return as stp_blue_make. `found->candidates` is to be destroyed, also after a failure
STP_MUST_USE stp_result stp_blue_find_candidates(const stp_scene* scene, uint32_t node,
                                                 const stp_blue_desc* desc,
                                                 stp_blue_candidates* found);
