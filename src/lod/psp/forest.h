// SPDX-License-Identifier: MIT
// The merge forest of a set of splats: merges pairs of neighbouring splats, the pair with the least
// error first (Wu, Zhang, Kobbelt 2005, sections 2 to 4).
#pragma once

#include "base/core/context.h"
#include "base/io/spill.h"
#include "lod/psp/ellipse.h"

/// Input. Arrays belong to the caller, and are only read.
typedef struct stp_psp_points {
    uint32_t count;
    const float* positions; ///< 3 per point
    const float* normals;   ///< NULL, or 3 per point: unit length, or zero if unknown
    const uint8_t* colors;  ///< NULL: white, or sRGB
    uint32_t color_bytes;   ///< bytes from one colour to the next, at least 3; 0: 3
    const float* areas;     ///< for STP_PSP_REGIONS: surface area that a point represents; above 0
} stp_psp_points;

/// Colour of a point. Requires colours.
static inline const uint8_t* stp_psp_color(const stp_psp_points* points, size_t point)
{
    return points->colors + point * (points->color_bytes != 0 ? points->color_bytes : 3);
}

/// Error metric of a merge.
typedef enum stp_psp_metric {
    STP_PSP_NORMALS,   ///< deviation of normals, by area (4.2, "L2,1")
    STP_PSP_DISTANCES, ///< distances of all points from the splat that represents them (4.1, "L2")
    STP_PSP_REGIONS,   ///< difference between pictures of the splat and of its points (region.h)
} stp_psp_metric;

typedef struct stp_psp_desc {
    stp_psp_metric metric;
    uint32_t neighbours; ///< neighbours per point, 1 to STP_NEIGHBOURS_MAX; the paper's k is 8
    /// Minimum cosine between normals of merged splats. Default 0: a right angle
    float min_cosine;
    /// The signs of normals are a guess: splats that face away from each other are merged as if
    /// they faced the same way
    bool two_sided;
    /// A splat whose best merge became worse moves back in the queue immediately, not when it
    /// reaches the front. The result is the same.
    bool eager;
    /// If no merge is possible while more splats than the target are left, links each splat with
    /// its nearest ones again and continues. So the target is always reached, unless `keep_angle`
    /// is set. From then on `min_cosine` applies only with `keep_angle`.
    bool connect_components;
    bool keep_angle;
    /// Maximum splats per queue, at least 8; 0: default. Larger inputs are merged in pieces
    uint32_t piece_size;
    /// For stp_psp_decimate: stores data that grows with the number of points in temporary files in
    /// the same folder, not in memory. If the points are mapped from this file, releases their
    /// pages, too. The result is the same. NULL: all in memory.
    stp_spill* spill;
} stp_psp_desc;

stp_psp_desc stp_psp_desc_default(void);

/// A merge of two splats into one. Splats are numbered: first the points, then the merges in order.
typedef struct stp_psp_merge {
    uint32_t left, right;
    /// Error by the metric, weighted by the distance of the two (formulas 1 and 2) except for
    /// STP_PSP_REGIONS; in model units, from a float in merge units
    double error;
    /// largest error of the merge and all merges below it. Never decreases from merge to merge
    double level;
} stp_psp_merge;

typedef struct stp_psp_forest {
    uint32_t point_count, merge_count;
    stp_ellipse* ellipses; ///< ellipses of the points, then of the merges
    uint8_t* colors;       ///< 3 per splat, sRGB; means by area
    stp_psp_merge* merges;
    uint32_t* parents; ///< per splat, the merge that consumed it; UINT32_MAX: none
    bool ranked;       ///< levels are ranks of merges (stp_psp_rank_merges)
} stp_psp_forest;

/// Merges until `target` splats are left, or no merge is allowed. Points whose neighbours all face
/// another way remain. One queue merges up to `piece_size` splats; larger inputs are merged in
/// pieces on all threads. The result is deterministic: it depends on `piece_size`, but not on the
/// number of threads.
///
/// NaN coordinates count as 0; magnitudes are clamped to 1e18.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (more than 2^30 points; logged). Freed
///         by stp_psp_forest_destroy, also after a failure
STP_MUST_USE stp_result stp_psp_forest_make(stp_context* context, const stp_psp_points* points,
                                            const stp_psp_desc* desc, uint32_t target,
                                            stp_psp_forest* forest);
void stp_psp_forest_destroy(stp_context* context, stp_psp_forest* forest);

/// Replaces the levels of a forest by those of STP_PSP_REGIONS, whichever metric chose the merges:
/// the largest difference between pictures (region.h) of a merge and all merges below it, as an
/// area. They may decrease from merge to merge.
/// @param points those of the forest, with areas
/// @param two_sided as in stp_psp_desc
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; the levels are unchanged)
STP_MUST_USE stp_result stp_psp_measure_pictures(stp_context* context, const stp_psp_points* points,
                                                 bool two_sided, stp_psp_forest* forest);

/// The remaining splats, without the merge history.
typedef struct stp_psp_splats {
    uint32_t count;
    stp_ellipse* ellipses;
    uint8_t* colors;  ///< 3 per splat, sRGB
    float* areas;     ///< surface area: represented (STP_PSP_REGIONS), otherwise the ellipse's
    uint32_t* firsts; ///< smallest index of the represented points
} stp_psp_splats;

/// Approximate peak memory of stp_psp_decimate in bytes, without `spill` and without the points.
uint64_t stp_psp_decimate_bytes(uint32_t count, const stp_psp_desc* desc);

/// Merges as stp_psp_forest_make does, but keeps only the splats that are left at the target,
/// ordered by the smallest index of their points. Needs far less memory
/// (docs/algorithms/progressive-splatting.md).
/// @return as stp_psp_forest_make; with `spill` also STP_ERROR_IO (logged). Freed by
///         stp_psp_splats_destroy, also after a failure
STP_MUST_USE stp_result stp_psp_decimate(stp_context* context, const stp_psp_points* points,
                                         const stp_psp_desc* desc, uint32_t target,
                                         stp_psp_splats* splats);
void stp_psp_splats_destroy(stp_context* context, stp_psp_splats* splats);

// Split order of a merge forest, and the levels at which each splat is drawn (Wu, Zhang, Kobbelt
// 2005, section 5).

/// Splats of a forest: first the roots, then the two parts of each merge, in the order of splits.
/// The merge with the highest level is split first.
typedef struct stp_psp_sequence {
    uint32_t count;
    uint32_t* splats; ///< numbers in the forest
    /// Codes (base/splats/splat_codes.h). The lowest level is 0 for samples and above 0 for merges
    /// that are split
    uint32_t* ranges;
    float* highest_left; ///< highest level among a splat and all after it
} stp_psp_sequence;

#define STP_PSP_RANK_MAX 0x1p-40f ///< all ranks of merges are lower levels

/// Replaces the levels of a forest by ranks, with which its sequence is the paper's record of
/// merges: splits undo the merges in reverse order. Ranks are levels below any size that a view
/// asks for, so it draws the splats that were left, and a count of splats draws the state of that
/// count. With more than about 40,000 merges, runs of consecutive merges share ranks, and are
/// undone in another order within a run.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; the levels are unchanged)
STP_MUST_USE stp_result stp_psp_rank_merges(stp_context* context, stp_psp_forest* forest);

/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_psp_sequence_destroy, also after
///         a failure
STP_MUST_USE stp_result stp_psp_sequence_make(stp_context* context, const stp_psp_forest* forest,
                                              stp_psp_sequence* sequence);
/// Shortens a sequence to states of at most `limit` splats; the base set always stays. What is not
/// split any more becomes a leaf, which is drawn down to level 0.
/// @param left_out the level from which on nothing that was left out would be drawn, rounded up to
/// a code; 0 if all stays
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; the sequence is unchanged)
STP_MUST_USE stp_result stp_psp_sequence_shorten(stp_context* context, stp_psp_sequence* sequence,
                                                 uint32_t limit, float* left_out);
void stp_psp_sequence_destroy(stp_context* context, stp_psp_sequence* sequence);
