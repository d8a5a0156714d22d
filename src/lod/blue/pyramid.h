// SPDX-License-Identifier: MIT
// The colour pyramid while it is made, for the files that do it: pyramid.c (colours, and the whole) and
// pyramid_coverage.c (how much of each disk is surface), pyramid_chance.c (with what chance its pixels are drawn).
#pragma once

#include "base/coverage.h"
#include "lod/blue/finish.h"
#include "lod/blue/stencil.h"
#include "lod/neighbours.h"

/// One entry of the pyramid.
typedef struct stp_pyramid_entry {
    uint32_t color[3]; ///< linear, whole numbers
    uint16_t alpha;    ///< mean opacity, 65535 is 1
    uint16_t fraction; ///< how much of the disk is surface, opacity included, 65535 is 1
    float area;        ///< of the surface nearest to it, in STP_AREA_UNITS
    float toward[3];   ///< the same, times its normals: vectors, summed
    uint8_t coverage;  ///< result: what is drawn of the disk (base/coverage.h)
} stp_pyramid_entry;

typedef struct stp_pyramid_sum {
    uint64_t color[3], weight, alpha, area;
    int64_t toward[3];
} stp_pyramid_sum;

enum { STP_AREA_UNITS = 4096 }; ///< a pixel of the capture, where areas are whole numbers

/// How much surface candidates stand for, in STP_AREA_UNITS.
typedef struct stp_candidate_areas {
    uint32_t captured, blended, filled; ///< each of those that were captured as pixels
    uint32_t first_filled, first_of_sets;
    const float* of_sets; ///< scene units squared
    double per_area;      ///< STP_AREA_UNITS in a scene unit squared
} stp_candidate_areas;

stp_candidate_areas stp_candidate_areas_make(const stp_candidates* candidates);

/// At least 1.
static inline uint64_t stp_candidate_area(const stp_candidate_areas* areas, uint32_t candidate,
                                          uint8_t alpha)
{
    if (candidate >= areas->first_of_sets) {
        double area = (double)areas->of_sets[candidate - areas->first_of_sets] * areas->per_area;
        return (uint64_t)(area < 1.0 ? 1.0 : area > 0x1p40 ? 0x1p40 : area);
    }
    return candidate >= areas->first_filled ? areas->filled
           : alpha < 255                    ? areas->blended
                                            : areas->captured;
}

/// What codes of coverage show of a disk.
typedef struct stp_cut_table {
    uint64_t cells[256]; ///< of the stencil
    float areas[256];    ///< of the disk's area, 0 to 1
    stp_disk_cut cuts[256];
    float farthest; ///< how far a cut disk reaches, at most, along the direction of its cut
} stp_cut_table;

typedef struct stp_pyramid {
    stp_context* context;
    const stp_pyramid_input* input;
    stp_splats* surfels;
    stp_stencil stencil;
    stp_cut_table cuts;
    uint32_t linear[256];
    stp_candidate_areas areas;
    stp_pyramid_entry* octaves[STP_OCTAVE_LIMIT]; ///< entries of each octave, in one array
    uint16_t* fractions[STP_OCTAVE_LIMIT];        ///< the same fractions, as columns for searches
    stp_pyramid_entry* entries;
    size_t entry_count; ///< of all octaves
    uint16_t* fraction_column;
    stp_pyramid_sum* sums;
    stp_grid candidates; ///< all, in cells made for the finest octave
    uint32_t* nearest;   ///< of each sample, in its grid's order
    /// Of the finest octave that is not drawn whole, made when it comes; coarser ones use the first of them.
    stp_disk* disks;
    uint32_t* visit; ///< the surfels of one prefix along a space-filling curve
    uint32_t visit_count;
} stp_pyramid;

/// How an octave is made.
typedef struct stp_octave_plan {
    float radius;         ///< to what its prefix covers
    float disk_radius;    ///< of the disks drawn with it
    uint32_t dense_count; ///< surfels that sample the disks; 0: every stride-th candidate does
    uint32_t stride;
    float cell; ///< of the grids
} stp_octave_plan;

static inline uint16_t stp_pyramid_fraction(double value)
{
    return (uint16_t)(value * 65535.0 + 0.5);
}

/// Spacings in the radius of a disk of points, below which they are too few to tell where their surface ends.
#define STP_LEAST_SPACINGS 3.0

/// Whether all disks of an octave are drawn whole, whatever lies around them: those of a cloud that reach few points, or of
/// points that are all in one place.
bool stp_pyramid_is_whole(const stp_pyramid* p, const stp_octave_plan* plan);

/// How an octave is made: what samples its disks, and the cells to look in.
void stp_pyramid_plan_octave(const stp_pyramid* p, uint32_t octave, stp_octave_plan* plan);

/// Fills the fractions of an octave, whose entries have their opacities; finer ones are done. `p->candidates` is there.
STP_MUST_USE stp_result stp_pyramid_cover(stp_pyramid* p, uint32_t octave,
                                          const stp_octave_plan* plan);
enum {
    STP_VIEWS_TOLD = 8
}; ///< directions of a capture that are told apart, where there are so many

/// What is found in the cylinder over a surfel's disk. Lengths are over the disk's radius.
typedef struct stp_surroundings {
    uint64_t cells; ///< of the stencil, on the disk's axes (stp_disk_axes_of)
    float area;   ///< of what faces as the surfel does, as seen along its normal, in STP_AREA_UNITS
    float total;  ///< area of all that is there
    float others; ///< the part of `area` that is not of the views below
    /// Of each direction of the capture, how much its pixels cover of the disk as seen from there, 0 to about 1: the share
    /// of its rays that meet anything. All 0 where candidates do not tell.
    float views[STP_VIEWS_TOLD];
    float reach[STP_CUT_DIRECTIONS]; ///< how far anything lies in each direction; -1: nothing
} stp_surroundings;

typedef struct stp_surroundings_search {
    const stp_pyramid* pyramid;
    const stp_grid* samples; ///< candidates; cells as wide as `radius`, or wider
    uint32_t stride;         ///< each stands for so many
    float footprint;         ///< half the side of the square that one stands for, over the radius
    const uint32_t* visit;   ///< surfels
    size_t count;
    float radius; ///< of the disks
    /// Only cells and reach are asked for, and nothing of disks that reach farther on all sides than this (a square).
    bool only_reach;
    float reach_asked;
    stp_surroundings* found;        ///< result: of each surfel visited
    const uint32_t* view_starts;    ///< candidates of each direction, or NULL
    stp_vec3 views[STP_VIEWS_TOLD]; ///< filled in: the directions
    float pixel;                    ///< filled in: of the capture, over the disk's area
    float across[STP_CUT_DIRECTIONS / 2], along[STP_CUT_DIRECTIONS / 2]; ///< filled in
} stp_surroundings_search;

void stp_surroundings_search_run(stp_context* context, stp_surroundings_search* search);

void stp_cut_table_make(const stp_stencil* stencil, stp_cut_table* table);
/// The code of the smallest part of a disk that holds all that was found, but for `slack` beside it (parts of the radius).
uint8_t stp_cut_choose(const stp_cut_table* table, const stp_surroundings* found, float slack);

/// Fills the coverages of an octave, from fractions and areas.
STP_MUST_USE stp_result stp_pyramid_choose_chances(stp_pyramid* p, uint32_t octave,
                                                   const stp_octave_plan* plan);

/// Draws disks of an octave whole where their coverages would show the background inside a silhouette.
STP_MUST_USE stp_result stp_pyramid_close_holes(stp_pyramid* p, uint32_t octave,
                                                const stp_octave_plan* plan);
