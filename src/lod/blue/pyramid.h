// SPDX-License-Identifier: MIT
// State of the colour pyramid's construction, for pyramid.c (colours, overall process),
// pyramid_light.c (light normals), pyramid_coverage.c (share of each disk that is surface),
// pyramid_surroundings.c (area that each disk must occlude), pyramid_chance.c (drawn part of each
// disk) and pyramid_holes.c (closing of visible holes).
#pragma once

#include "base/splats/coverage.h"
#include "lod/blue/finish.h"
#include "lod/blue/stencil.h"
#include "lod/neighbours.h"

#include <assert.h>

/// One entry of the pyramid.
typedef struct stp_pyramid_entry {
    uint32_t color[3]; ///< linear, integers
    uint16_t alpha;    ///< mean opacity, 65535 is 1
    uint16_t fraction; ///< share of the disk that is surface, times opacity, 65535 is 1
    float area;        ///< area of the surface nearest to it, in STP_AREA_UNITS
    float toward[3];   ///< sum of that surface's normals, each times its area
    uint8_t coverage;  ///< result: drawn part of the disk (base/splats/coverage.h)
} stp_pyramid_entry;

typedef struct stp_pyramid_sum {
    uint64_t color[3], weight, alpha, area;
    int64_t toward[3];
} stp_pyramid_sum;

enum { STP_AREA_UNITS = 4096 }; ///< a pixel of the capture; areas are integers

/// Area that candidates represent, in STP_AREA_UNITS.
typedef struct stp_candidate_areas {
    uint32_t captured, blended, filled; ///< area of an opaque, a blended, and a filled-in candidate
    uint32_t first_filled, first_of_sets;
    const float* of_sets; ///< scene units squared
    double per_area;      ///< STP_AREA_UNITS per scene unit squared
} stp_candidate_areas;

stp_candidate_areas stp_candidate_areas_make(const stp_candidates* candidates);

/// Area that a candidate represents, in STP_AREA_UNITS: at least 1.
static inline uint64_t stp_candidate_area(const stp_candidate_areas* areas, uint32_t candidate,
                                          uint8_t alpha)
{
    if (candidate >= areas->first_of_sets) {
        assert(areas->of_sets != NULL && "splats of sets have areas");
        double area = (double)areas->of_sets[candidate - areas->first_of_sets] * areas->per_area;
        return (uint64_t)(area < 1.0 ? 1.0 : area > 0x1p40 ? 0x1p40 : area);
    }
    return candidate >= areas->first_filled ? areas->filled
           : alpha < 255                    ? areas->blended
                                            : areas->captured;
}

/// Parts of a disk that coverage codes draw.
typedef struct stp_clip_table {
    uint64_t cells[256]; ///< cells of the stencil
    float areas[256];    ///< share of the disk's area, 0 to 1
    stp_disk_clip clips[256];
    float farthest; ///< maximum extent of a clip disk along the direction of its clip
} stp_clip_table;

typedef struct stp_pyramid {
    stp_context* context;
    const stp_pyramid_input* input;
    stp_splats* surfels;
    stp_stencil stencil;
    stp_clip_table clips;
    uint32_t linear[256];
    stp_candidate_areas areas;
    stp_pyramid_entry* octaves[STP_OCTAVE_LIMIT]; ///< entries of each octave, in one array
    uint16_t* fractions[STP_OCTAVE_LIMIT];        ///< the same fractions, as columns for searches
    stp_pyramid_entry* entries;
    size_t entry_count; ///< number of entries of all octaves
    uint16_t* fraction_column;
    stp_pyramid_sum* sums;
    /// 3 per entry: sum of the light normals of the surface nearest to it, each times its area;
    /// NULL: candidates have none of their own, and `toward` is that sum
    float* lights;
    int64_t* light_sums; ///< 3 per surfel, like `sums`
    stp_grid candidates; ///< all samples, in cells for the finest octave
    uint32_t* nearest;   ///< nearest surfel of each sample, in its grid's order
    /// For the finest octave that is not drawn whole, created on first use; coarser ones use a
    /// prefix.
    stp_disk* disks;
    uint32_t* visit; ///< surfels of a prefix along a space-filling curve
    uint32_t visit_count;
} stp_pyramid;

/// Parameters of an octave.
typedef struct stp_octave_plan {
    float radius;         ///< coverage radius of its prefix
    float disk_radius;    ///< radius of its disks
    uint32_t dense_count; ///< number of surfels that sample the disks; 0: every stride-th candidate
    uint32_t stride;
    float cell; ///< side of the grids' cells
} stp_octave_plan;

/// Whether each candidate was chosen: surfels of the finest octave have their own colours.
static inline bool stp_pyramid_keeps_candidates(const stp_pyramid* p)
{
    return p->input->finish->candidates->count == p->surfels->count;
}

/// Entries of the pyramid before an octave.
static inline size_t stp_pyramid_first(const stp_pyramid* p, uint32_t octave)
{
    return (size_t)(p->octaves[octave] - p->entries);
}

static inline uint16_t stp_pyramid_fraction(double value)
{
    assert(value >= 0.0 && value < 1.0 + 1e-6);
    return (uint16_t)(value * 65535.0 + 0.5);
}

/// Minimum point spacings per disk radius: with fewer points, the border of their surface is
/// unknown.
#define STP_MIN_SPACINGS 3.0

/// Whether all disks of an octave are drawn whole regardless of their surroundings: for clouds
/// whose disks contain few points, or with all points in one place.
bool stp_pyramid_is_whole(const stp_pyramid* p, const stp_octave_plan* plan);

/// Sets an octave's parameters: the samples of its disks, and the search cells.
void stp_pyramid_plan_octave(const stp_pyramid* p, uint32_t octave, stp_octave_plan* plan);

/// Allocates the sums of light normals, if candidates have any. @param entries of all octaves
/// @param summed surfels of octaves that are summed up
STP_MUST_USE stp_result stp_pyramid_allocate_lights(stp_pyramid* p, size_t entries, size_t summed);
/// Sums the light normals of an octave whose samples have been assigned and summed.
void stp_pyramid_sum_lights(stp_pyramid* p, uint32_t octave, const stp_grid* samples);
/// Takes the light normals of the finest octave from the surfels' own candidates.
void stp_pyramid_keep_lights(stp_pyramid* p, uint32_t octave);
/// Writes the light normals of all octaves that tell anything to the surfels, whose normals must be
/// there. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_pyramid_write_lights(const stp_pyramid* p);

/// Fills the fractions of an octave, whose entries have their opacities. Finer octaves must be
/// done, and `p->candidates` set.
STP_MUST_USE stp_result stp_pyramid_cover(stp_pyramid* p, uint32_t octave,
                                          const stp_octave_plan* plan);
enum { STP_VIEWS_TOLD = 8 }; ///< maximum distinguished directions of a capture

/// Content of the cylinder over a surfel's disk. Lengths are relative to the disk's radius.
typedef struct stp_surroundings {
    uint64_t cells; ///< cells of the stencil, on the disk's axes (stp_disk_axes_of)
    /// Projected area, along the normal, of surface that faces as the surfel does, in
    /// STP_AREA_UNITS
    float area;
    float total;  ///< total area
    float others; ///< part of `area` that is not from the views below
    /// Per capture direction, the share of its rays through the disk that hit anything, 0 to about
    /// 1. All 0 if unknown.
    float views[STP_VIEWS_TOLD];
    float reach[STP_CLIP_DIRECTIONS]; ///< extent of the content in each direction; -1: none
} stp_surroundings;

typedef struct stp_surroundings_search {
    const stp_pyramid* pyramid;
    const stp_grid* samples; ///< candidates; cells as wide as `radius`, or wider
    uint32_t stride;         ///< weight of each
    /// Half the side of the square that one represents, relative to the radius
    float footprint;
    const uint32_t* visit; ///< surfels
    size_t count;
    float radius; ///< radius of the disks
    /// Computes cells and extent only, and stops for disks whose content extends farther than
    /// `reach_asked` on all sides.
    bool only_reach;
    float reach_asked;              ///< squared extent, relative to the radius
    stp_surroundings* found;        ///< result: one per visited surfel, in that order
    const uint32_t* view_starts;    ///< filled in: first candidate of each direction, or NULL
    stp_vec3 views[STP_VIEWS_TOLD]; ///< filled in: the directions
    float pixel;                    ///< filled in: area of a capture pixel over a disk's
    float across[STP_CLIP_DIRECTIONS / 2], along[STP_CLIP_DIRECTIONS / 2]; ///< filled in
} stp_surroundings_search;

void stp_surroundings_search_run(stp_context* context, stp_surroundings_search* search);

void stp_clip_table_make(const stp_stencil* stencil, stp_clip_table* table);
/// Code of the smallest part of a disk that contains all its content, up to `slack` outside
/// (relative to the radius).
uint8_t stp_clip_choose(const stp_clip_table* table, const stp_surroundings* found, float slack);

/// Fills the coverages of an octave from fractions and areas.
STP_MUST_USE stp_result stp_pyramid_choose_chances(stp_pyramid* p, uint32_t octave,
                                                   const stp_octave_plan* plan);

/// Draws disks of an octave whole where their coverages would show the background inside a
/// silhouette.
STP_MUST_USE stp_result stp_pyramid_close_holes(stp_pyramid* p, uint32_t octave,
                                                const stp_octave_plan* plan);
