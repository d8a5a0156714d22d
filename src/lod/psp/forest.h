// SPDX-License-Identifier: MIT
// The merge forest of a set of splats: neighbouring splats are merged in pairs, the pair with the
// least error first (Wu, Zhang, Kobbelt 2005, 2 to 4).
#pragma once

#include "base/context.h"
#include "base/spill.h"
#include "lod/psp/ellipse.h"

/// What is merged. Arrays are the caller's, and are only read.
typedef struct stp_psp_points {
    uint32_t count;
    const float* positions; ///< 3 a point; finite
    const float* normals;   ///< NULL, or 3 a point: of unit length, or zero where nobody knows
    const uint8_t* colors;  ///< NULL: white, or sRGB
    uint32_t color_bytes;   ///< of a point: 3, or more, which are not read; 0: 3
    const float*
        areas; ///< of STP_PSP_REGIONS: area of the surface that a point stands for; above 0
} stp_psp_points;

/// The colour of a point. There are colours.
static inline const uint8_t* stp_psp_color(const stp_psp_points* points, size_t point)
{
    return points->colors + point * (points->color_bytes != 0 ? points->color_bytes : 3);
}

/// How the error of a merge is measured.
typedef enum stp_psp_metric {
    STP_PSP_NORMALS,   ///< deviation of normals, by area (4.2, "L2,1")
    STP_PSP_DISTANCES, ///< distances of all points from the splat that stands for them (4.1, "L2")
    STP_PSP_REGIONS, ///< how much a picture of the splat differs from one of its points (region.h)
} stp_psp_metric;

typedef struct stp_psp_desc {
    stp_psp_metric metric;
    uint32_t neighbours; ///< of a point, 1 to STP_NEIGHBOURS_MOST; the paper's k is 8
    /// of the normals of splats that may be merged; the default is 0: a right angle
    float least_cosine;
    /// A splat whose best merge became worse moves back in the queue at once, not when it comes up.
    /// The result is the same.
    bool eager;
    /// Where no merge is possible and more than the target are left, each splat is linked with the
    /// nearest ones anew, and merging goes on, so the target is always reached. From then on
    /// `least_cosine` holds only with `keep_angle`, and then more splats than the target may be
    /// left.
    bool connect_components;
    bool keep_angle;
    /// splats that one queue merges, 8 and more; 0: the default. More are merged in pieces
    uint32_t piece_size;
    /// Of stp_psp_decimate: what grows with the number of points lies in files beside this one, not
    /// in memory. Where the points lie in this one, their pages are released, too. The result is
    /// the same. NULL: all is in memory.
    stp_spill* spill;
} stp_psp_desc;

stp_psp_desc stp_psp_desc_default(void);

/// Two splats become one. Splats have numbers: those of points first, then that of each merge in
/// order.
typedef struct stp_psp_merge {
    uint32_t left, right;
    double
        error; ///< as the metric has it, weighted by the distance of the two (formulas 1 and 2); in
               ///< model units, and rounded to a float in those of the merge
    /// the largest error of the merge and of all below it. Never decreases from merge to merge
    double level;
} stp_psp_merge;

typedef struct stp_psp_forest {
    uint32_t point_count, merge_count;
    stp_ellipse* ellipses; ///< of points, then of merges
    uint8_t* colors;       ///< 3 a splat, sRGB; means by area
    stp_psp_merge* merges;
    uint32_t* parents; ///< of a splat the merge that took it; UINT32_MAX: none
} stp_psp_forest;

/// Merges until `target` splats are left, or none can be merged. Points without neighbours, or with
/// those alone that face elsewhere, stay. One queue merges up to `piece_size` splats; more are
/// merged in pieces on all threads. Deterministic; the result does not depend on the number of
/// threads, but it depends on `piece_size`.
///
/// Coordinates that are not numbers count as 0; magnitudes above 1e18 are cut to that.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (2^30 points and more; logged). Freed
/// by
///         stp_psp_forest_destroy, also after a failure
STP_MUST_USE stp_result stp_psp_forest_make(stp_context* context, const stp_psp_points* points,
                                            const stp_psp_desc* desc, uint32_t target,
                                            stp_psp_forest* forest);
void stp_psp_forest_destroy(stp_context* context, stp_psp_forest* forest);

/// The splats that are there when so many are left, ascending.
/// @param splats room for as many as `count`, or as there are roots, whichever is more
/// @return how many: `count`; the number of points or of roots where it is more or less than those
uint32_t stp_psp_forest_cut(const stp_psp_forest* forest, uint32_t count, uint32_t* splats);

/// The splats that are left, without their history.
typedef struct stp_psp_splats {
    uint32_t count;
    stp_ellipse* ellipses;
    uint8_t* colors;  ///< 3 a splat, sRGB
    float* areas;     ///< by STP_PSP_REGIONS of the surface that it stands for, else of the ellipse
    uint32_t* firsts; ///< the least index of the points that it stands for
} stp_psp_splats;

/// About how many bytes stp_psp_decimate takes at its peak without `spill`, besides the points.
uint64_t stp_psp_decimate_bytes(uint32_t count, const stp_psp_desc* desc);

/// Merges as stp_psp_forest_make does, and keeps only what is left: the same splats as those of
/// stp_psp_forest_cut at the target, in order of the least index of the points they stand for.
/// Takes far less memory (docs/algorithms/progressive-splatting.md).
/// @return as stp_psp_forest_make; with `spill` also STP_ERROR_IO (logged). Freed by
/// stp_psp_splats_destroy, also after a failure
STP_MUST_USE stp_result stp_psp_decimate(stp_context* context, const stp_psp_points* points,
                                         const stp_psp_desc* desc, uint32_t target,
                                         stp_psp_splats* splats);
void stp_psp_splats_destroy(stp_context* context, stp_psp_splats* splats);
