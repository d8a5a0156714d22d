// SPDX-License-Identifier: MIT
//
// The drawn part of each disk. Disks of a surface overlap and occlude the background: they are
// drawn whole. A disk that extends beyond a border, a beam or a wire is clipped along it. Disks over
// scattered geometry draw as many pixels as the surface nearest to the surfel covers, so that
// leaves, lattices and distant trees keep their area at any disk size. That area is counted
// together with the colours, in pixels of the capture.
#include "lod/blue/pyramid.h"

#include <assert.h>

// Disks that are known to be full have more than this share of the surface nearest to surfels of
// whole surfaces.
#define WHOLE 0.5
// Share of the drawn part's cells that are hit: below the first value the disk has holes, from the
// second it has none.
#define OPEN_CELLS 0.6
#define FULL_CELLS 0.8
// The same for the share of rays that hit anything.
#define OPEN_AREA 0.5
#define FULL_AREA 0.57
// The same for the finest octave, with a dozen candidates per disk.
#define OPEN_AREA_OF_FINEST 0.05
#define FULL_AREA_OF_FINEST 0.12
// Mean positive cosine of the content to the surfel's normal: a quarter among leaves, a half if
// both sides of a plate are visible.
#define OPEN_FACING 0.25
#define FULL_FACING 0.35
// Above this, surfaces are parallel to the disk, and their corners fill less of the drawn part.
#define OPEN_CORNER 0.3
#define FULL_CORNER 0.34
#define OPEN_CORNER_CELLS 0.5
#define FULL_CORNER_CELLS 0.53
// Still less if all are one smooth surface.
#define OPEN_SMOOTH 0.6
#define FULL_SMOOTH 0.8
#define OPEN_SMOOTH_CELLS 0.35
#define FULL_SMOOTH_CELLS 0.42
// The same for strips with less area than this, which contain few candidates.
#define NARROW 0.3
#define OPEN_NARROW_CELLS 0.2
#define FULL_NARROW_CELLS 0.4
// Surface whose mean normal is beyond this cosine is a different object, such as the ground below a
// tree.
#define MIN_FACING 0.3
// Candidates examined per disk.
#define DISK_SAMPLES 128.0
#define MAX_STRIDE 4096.0
// Surface counts as opaque from this mean opacity. Opacities of children are averaged level by
// level: border disks with a few holes must not open the whole surface at coarser levels.
#define OPAQUE 0.99
#define OPAQUE_OF_SETS 0.8
// Maximum distance of a candidate outside the drawn part, relative to the radius.
#define SLACK 0.04f

// A blended surface is captured in half its pixels.
#define BLENDED 2.0

stp_candidate_areas stp_candidate_areas_make(const stp_candidates* candidates)
{
    assert(candidates->filled <= stp_first_of_sets(candidates));
    double views = (double)candidates->direction_count;
    // one of n directions sees a quarter of its pixels' area, averaged over all orientations
    double each = views > 0.0 ? 4.0 / views : 1.0;
    double pixel = candidates->pixel_size;
    return (stp_candidate_areas){
        .captured = (uint32_t)(STP_AREA_UNITS * each + 0.5),
        .blended = (uint32_t)(STP_AREA_UNITS * each * BLENDED + 0.5),
        .filled = STP_AREA_UNITS,
        .first_filled = stp_first_of_sets(candidates) - candidates->filled,
        .first_of_sets = stp_first_of_sets(candidates),
        .of_sets = candidates->set_areas,
        .per_area = pixel > 0.0 ? STP_AREA_UNITS / (pixel * pixel) : 0.0,
    };
}

static double ramp(double value, double low, double high)
{
    assert(low < high);
    return stp_clampd((value - low) / (high - low), 0.0, 1.0);
}

// Mean cosine between the surfel and the surface nearest to it.
static double facing(const stp_pyramid* p, const stp_pyramid_entry* e, uint32_t surfel)
{
    const float* n = p->input->normals + 3 * (size_t)surfel;
    double along = (double)n[0] * (double)e->toward[0] + (double)n[1] * (double)e->toward[1] +
                   (double)n[2] * (double)e->toward[2];
    return e->area > 0.0f ? stp_clampd(along / (double)e->area, 0.0, 1.0) : 0.0;
}

// Disks of one prefix overlap about twice, so each is drawn with a probability whose union is the
// fraction.
static double overlapping_chance(uint16_t fraction)
{
    return 1.0 - sqrt(1.0 - (double)fraction / 65535.0);
}

// Share of the nearest surface that counts as the surfel's own.
static double own_part(double cosine)
{
    double part = stp_clampd(cosine / MIN_FACING, 0.0, 1.0);
    return part * part * part * part;
}

// Parameters for choosing an octave's coverages. Lengths are in scene units, areas in
// STP_AREA_UNITS.
typedef struct chooser {
    stp_pyramid* p;
    uint32_t octave;
    stp_pyramid_entry* entries;
    float disk_radius;
    double pixels;      ///< radius of the disks in pixels of the capture
    uint32_t stride;    ///< every stride-th candidate is examined
    float margin;       ///< extent of surface beyond them, relative to the disks' radius
    double disk, whole; ///< areas: of a disk; of the surface nearest to a surfel of a whole surface
    bool is_cloud;
} chooser;

static chooser make_chooser(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    double pixel = p->input->finish->candidates->pixel_size;
    assert(pixel > 0.0 && plan->disk_radius > 0.0f && "other octaves are whole");
    double reach = (double)plan->radius / pixel, disk = (double)plan->disk_radius / pixel;
    reach = reach > 0.5 ? reach : 0.5;
    // four of eight views see a surface, so there are two candidates per pixel; one for points
    double density = p->input->finish->candidates->direction_count != 0 ? 2.0 : 1.0;
    double stride = ceil(density * STP_PI * disk * disk / DISK_SAMPLES);
    stride = stride > 1.0 ? stride : 1.0;
    stride = stride < MAX_STRIDE ? stride : MAX_STRIDE;
    return (chooser){
        .p = p,
        .octave = octave,
        .entries = p->octaves[octave],
        .disk_radius = plan->disk_radius,
        .pixels = disk,
        .stride = (uint32_t)stride,
        .margin = (float)((density > 1.0 ? 0.25 : 0.5) * sqrt(stride / density) / disk),
        .disk = STP_PI * disk * disk * STP_AREA_UNITS,
        .whole = STP_WHOLE_SHARE * STP_PI * reach * reach * STP_AREA_UNITS,
        .is_cloud = p->input->finish->candidates->direction_count == 0,
    };
}

// Share of drawn pixels of a disk with holes. `hit`: the share that rays along its normal hit.
static double thin_share(const chooser* c, uint32_t surfel, double hit)
{
    const stp_pyramid_entry* e = &c->entries[surfel];
    double whole = overlapping_chance(e->fraction);
    double own = own_part(facing(c->p, e, surfel));
    double alpha =
        c->p->input->finish->candidates->set_count != 0 ? 1.0 : (double)e->alpha / 65535.0;
    double thin = stp_chance_of_share((double)e->area * own / c->disk) * alpha;
    // overlapping disks hide each other's pixels: draws more, so that together they cover the area
    double covered = hit < 0.9 ? hit : 0.9;
    thin *= covered > 0.01 ? -log(1.0 - covered) / covered : 1.0;
    return thin < whole ? thin : whole;
}

static bool is_opaque(const chooser* c, const stp_pyramid_entry* e)
{
    bool of_sets = c->p->input->finish->candidates->set_count != 0;
    return (double)e->alpha >= (of_sets ? OPAQUE_OF_SETS : OPAQUE) * 65535.0;
}

// Finds disks that are known to be whole: for a cloud, those with points all over; for a surface,
// those with enough opaque surface that faces as the surfel does. @return number of the others,
// which are listed along the curve
static size_t choose_whole(const chooser* c, uint32_t* doubtful)
{
    assert(c->p->visit_count == c->p->surfels->octave_ends[c->octave]);
    size_t count = 0;
    for (uint32_t at = 0; at < c->p->visit_count; ++at) {
        uint32_t i = c->p->visit[at];
        stp_pyramid_entry* e = &c->entries[i];
        bool full = stp_stencil_is_full(&c->p->stencil, c->p->disks[i].cells);
        if (full && !c->is_cloud) {
            double cosine = facing(c->p, e, i);
            full = is_opaque(c, e) && (double)e->area * cosine * cosine >= WHOLE * c->whole;
        }
        e->coverage = STP_COVERAGE_WHOLE;
        if (!full) {
            doubtful[count++] = i;
        }
    }
    return count;
}

// Share of rays through a disk that hit anything, in the view that sees most of it: parts hidden in
// other views are no less solid, and a lattice finer than the pixels looks equally open in all.
static double ray_share(const chooser* c, const stp_surroundings* found)
{
    float maximum = 0.0f;
    for (int k = 0; k < STP_VIEWS_TOLD; ++k) {
        maximum = stp_max(maximum, found->views[k]);
    }
    return (double)maximum + (double)found->others / c->disk;
}

// Chooses the drawn part of a disk from its surroundings.
static uint8_t choose(const chooser* c, uint32_t surfel, const stp_surroundings* found)
{
    const stp_clip_table* table = &c->p->clips;
    const stp_pyramid_entry* e = &c->entries[surfel];
    bool finest = c->octave + 1 == c->p->surfels->octave_count;
    uint8_t code = stp_clip_choose(table, found, SLACK - c->margin);
    assert(table->cells[code] != 0);
    double cells = (double)__builtin_popcountll(found->cells & table->cells[code]) /
                   (double)__builtin_popcountll(table->cells[code]);
    if (c->is_cloud) { // no holes, and no pixels
        return cells >= FULL_CELLS ? code : STP_COVERAGE_WHOLE;
    }
    assert(found->total >= 1.0f && !(found->area > found->total * 1.001f));
    bool corner = stp_stencil_is_solid(&c->p->stencil, found->cells);
    double hit = (double)__builtin_popcountll(found->cells & c->p->stencil.disk) /
                 (double)__builtin_popcountll(c->p->stencil.disk);
    hit = hit < (double)table->areas[code] ? hit : (double)table->areas[code];
    double area = ray_share(c, found) / hit;
    double agreement = (double)(found->area / found->total);
    double facing_part = ramp(agreement, OPEN_FACING, FULL_FACING);
    double solid = fmax(corner ? facing_part : 0.0, ramp(cells, OPEN_CELLS, FULL_CELLS));
    if ((double)table->areas[code] < NARROW) { // contains few samples
        solid = fmax(solid, ramp(cells, OPEN_NARROW_CELLS, FULL_NARROW_CELLS));
    }
    solid = fmax(solid, ramp(agreement, OPEN_CORNER, FULL_CORNER) *
                            ramp(cells, OPEN_CORNER_CELLS, FULL_CORNER_CELLS));
    solid = fmax(solid, ramp(agreement, OPEN_SMOOTH, FULL_SMOOTH) *
                            ramp(cells, OPEN_SMOOTH_CELLS, FULL_SMOOTH_CELLS));
    solid *= finest ? ramp(area, OPEN_AREA_OF_FINEST, FULL_AREA_OF_FINEST)
                    : ramp(area, OPEN_AREA, FULL_AREA);
    if (solid >= 1.0 && is_opaque(c, e)) {
        return code;
    }
    double share = is_opaque(c, e) ? (double)table->areas[code] : (double)e->alpha / 65535.0;
    share = 1.0 - sqrt(1.0 - (share < 1.0 ? share : 1.0));
    assert(share >= 0.0 && share <= 1.0 && solid >= 0.0 && solid <= 1.0);
    return stp_coverage_of_share(
        share * solid + thin_share(c, surfel, (double)found->area / c->disk) * (1.0 - solid));
}

static stp_result search_surroundings(const chooser* c, const uint32_t* doubtful, size_t count,
                                      stp_surroundings* found)
{
    stp_pyramid* p = c->p;
    stp_surroundings_search search = {.pyramid = p,
                                      .stride = c->stride,
                                      .visit = doubtful,
                                      .count = count,
                                      .radius = c->disk_radius,
                                      .only_reach = c->is_cloud,
                                      .found = found};
    float asked = stp_max(p->clips.farthest + SLACK - c->margin, 0.0f);
    search.reach_asked = asked * asked * 1.0001f; // disks with a larger extent are drawn whole
    // few samples, or irregular points: squares half again as wide close the gaps
    bool wide = c->stride == 1 || c->is_cloud;
    float spacing = sqrtf((float)c->stride) / (float)c->pixels;
    search.footprint = stp_min((wide ? 0.75f : 0.5f) * spacing, 0.5f);
    stp_grid grid;
    stp_result result =
        stp_grid_thin(p->context, &p->candidates, search.stride, c->disk_radius * 1.001f, &grid);
    if (result == STP_OK) {
        search.samples = &grid;
        stp_surroundings_search_run(p->context, &search);
        stp_grid_destroy(p->context, &grid);
    }
    return result;
}

static stp_result choose_all(const chooser* c, uint32_t* doubtful)
{
    size_t count = choose_whole(c, doubtful);
    if (count == 0) {
        return STP_OK;
    }
    stp_context* context = c->p->context;
    stp_surroundings* found = STP_NEW_ARRAY(context, stp_surroundings, count);
    stp_result result =
        found != NULL ? search_surroundings(c, doubtful, count, found) : stp_fail_memory(context);
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        c->entries[doubtful[i]].coverage = choose(c, doubtful[i], &found[i]);
    }
    stp_free(context, found);
    return result;
}

bool stp_pyramid_is_whole(const stp_pyramid* p, const stp_octave_plan* plan)
{
    const stp_candidates* c = p->input->finish->candidates;
    double spacings = (double)plan->disk_radius / c->pixel_size;
    return !(c->pixel_size > 0.0) || (c->direction_count == 0 && spacings < STP_MIN_SPACINGS);
}

stp_result stp_pyramid_choose_chances(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    if (stp_pyramid_is_whole(p, plan)) {
        for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
            p->octaves[octave][i].coverage = STP_COVERAGE_WHOLE;
        }
        return STP_OK;
    }
    chooser c = make_chooser(p, octave, plan);
    uint32_t* doubtful = STP_NEW_ARRAY(p->context, uint32_t, p->surfels->octave_ends[octave]);
    stp_result result = doubtful != NULL ? choose_all(&c, doubtful) : stp_fail_memory(p->context);
    stp_free(p->context, doubtful);
    return result;
}
