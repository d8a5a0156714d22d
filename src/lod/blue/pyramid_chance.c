// SPDX-License-Identifier: MIT
//
// What is drawn of each disk. Disks of a surface overlap and hide what lies behind: they are drawn whole. A disk that stands
// over the border of what is there, over a beam or a wire, is cut along it. Disks over what is scattered are drawn with so
// many pixels as the surface nearest to the surfel would cover, so that leaves, lattices and far trees keep their area,
// however large the disks. How much that is, is counted with the colours: pixels of the capture that belong to it.
#include "lod/blue/pyramid.h"

// Of the surface that is nearest to surfels of whole surfaces, disks that are known to be full have more than this.
#define WHOLE 0.5
// Of the cells of what is drawn of a disk, those that must be hit: below the first part it has holes, from the second on none.
#define OPEN_CELLS 0.6
#define FULL_CELLS 0.8
// The same of the rays through there that meet anything.
#define OPEN_AREA 0.5
#define FULL_AREA 0.57
// Of the finest octave, where a dozen candidates lie in a disk.
#define OPEN_AREA_OF_FINEST 0.05
#define FULL_AREA_OF_FINEST 0.12
// The mean cosine of all that lies in there to the surfel's normal, as far as it faces it: a quarter among leaves, a half
// where both sides of a plate are seen.
#define OPEN_FACING 0.25
#define FULL_FACING 0.35
// Where it is more, surfaces lie as the disk does, and their corners fill less of what is drawn.
#define OPEN_CORNER 0.3
#define FULL_CORNER 0.34
#define OPEN_CORNER_CELLS 0.5
#define FULL_CORNER_CELLS 0.53
// And less still where they are all one smooth surface.
#define OPEN_SMOOTH 0.6
#define FULL_SMOOTH 0.8
#define OPEN_SMOOTH_CELLS 0.35
#define FULL_SMOOTH_CELLS 0.42
// The same of strips of less area than this, in which few candidates lie.
#define NARROW 0.3
#define OPEN_NARROW_CELLS 0.2
#define FULL_NARROW_CELLS 0.4
// Surface that on the mean faces away by more than this cosine is something else: the ground below a tree.
#define LEAST_FACING 0.3
// Candidates that are looked at in a disk.
#define DISK_SAMPLES 128.0
#define MOST_STRIDE 4096.0
// Mean opacity from which surface counts as opaque. Opacities of children are averaged level by level: border disks that
// are drawn with a few holes must not open the whole surface above them.
#define OPAQUE 0.99
#define OPAQUE_OF_SETS 0.8
// How far beside the part that is drawn a candidate may lie, parts of the radius.
#define SLACK 0.04f

// A blended surface is captured in half its pixels.
#define BLENDED 2.0

stp_candidate_areas stp_candidate_areas_make(const stp_candidates* candidates)
{
    double views = (double)candidates->direction_count;
    // one of n directions sees a quarter of its pixels' area on the mean of all that face it or do not
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
    return stp_clampd((value - low) / (high - low), 0.0, 1.0);
}

// How much of the surface nearest to a surfel faces as it does: the mean cosine.
static double facing(const stp_pyramid* p, const stp_pyramid_entry* e, uint32_t surfel)
{
    const float* n = p->input->normals + 3 * (size_t)surfel;
    double along = (double)n[0] * (double)e->toward[0] + (double)n[1] * (double)e->toward[1] +
                   (double)n[2] * (double)e->toward[2];
    return e->area > 0.0f ? stp_clampd(along / (double)e->area, 0.0, 1.0) : 0.0;
}

// Disks of one prefix overlap about twice, so each is drawn with a chance whose union is the fraction.
static double overlapping_chance(uint16_t fraction)
{
    return 1.0 - sqrt(1.0 - (double)fraction / 65535.0);
}

// How much of the nearest surface is taken for the surfel's own.
static double own_part(double cosine)
{
    double part = stp_clampd(cosine / LEAST_FACING, 0.0, 1.0);
    return part * part * part * part;
}

// What an octave's coverages are chosen by. Lengths are in scene units, areas in STP_AREA_UNITS.
typedef struct chooser {
    stp_pyramid* p;
    uint32_t octave;
    stp_pyramid_entry* entries;
    float disk_radius;
    double pixels;      ///< of the capture, in the disks' radius
    uint32_t stride;    ///< of the candidates that are looked at
    float margin;       ///< how far beyond them surface may reach, over the disks' radius
    double disk, whole; ///< areas: of a disk; nearest to a surfel of a whole surface
    bool is_cloud;
} chooser;

static chooser make_chooser(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    double pixel = p->input->finish->candidates->pixel_size;
    double reach = (double)plan->radius / pixel, disk = (double)plan->disk_radius / pixel;
    reach = reach > 0.5 ? reach : 0.5;
    // of eight views four see a surface, so there are two candidates a pixel; one of points
    double density = p->input->finish->candidates->direction_count != 0 ? 2.0 : 1.0;
    double stride = ceil(density * STP_PI * disk * disk / DISK_SAMPLES);
    stride = stride > 1.0 ? stride : 1.0;
    stride = stride < MOST_STRIDE ? stride : MOST_STRIDE;
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

// The share of a disk's pixels where it is drawn with holes. `hit`: the part of it that rays along its normal hit.
static double thin_share(const chooser* c, uint32_t surfel, double hit)
{
    const stp_pyramid_entry* e = &c->entries[surfel];
    double whole = overlapping_chance(e->fraction);
    double own = own_part(facing(c->p, e, surfel));
    double alpha =
        c->p->input->finish->candidates->set_count != 0 ? 1.0 : (double)e->alpha / 65535.0;
    double thin = stp_chance_of_share((double)e->area * own / c->disk) * alpha;
    // disks that overlap hide each other's pixels: so many more are drawn that together they cover the area
    double covered = hit < 0.9 ? hit : 0.9;
    thin *= covered > 0.01 ? -log(1.0 - covered) / covered : 1.0;
    return thin < whole ? thin : whole;
}

static bool is_opaque(const chooser* c, const stp_pyramid_entry* e)
{
    bool of_sets = c->p->input->finish->candidates->set_count != 0;
    return (double)e->alpha >= (of_sets ? OPAQUE_OF_SETS : OPAQUE) * 65535.0;
}

// Disks that are known to be whole: of a cloud, those with points all over; of surface, only where enough of it faces as
// the surfel does, and is opaque. @return how many are not; they are listed, along the curve
static size_t choose_whole(const chooser* c, uint32_t* doubtful)
{
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

// The share of rays through a disk that meet anything, of the view that sees most of it: what is hidden from others is no
// less solid, and a lattice finer than the pixels is as open from all.
static double ray_share(const chooser* c, const stp_surroundings* found)
{
    float most = 0.0f;
    for (int k = 0; k < STP_VIEWS_TOLD; ++k) {
        most = stp_max(most, found->views[k]);
    }
    return (double)most + (double)found->others / c->disk;
}

// What is drawn of one disk, from what lies around it.
static uint8_t choose(const chooser* c, uint32_t surfel, const stp_surroundings* found)
{
    const stp_cut_table* table = &c->p->cuts;
    const stp_pyramid_entry* e = &c->entries[surfel];
    bool finest = c->octave + 1 == c->p->surfels->octave_count;
    uint8_t code = stp_cut_choose(table, found, SLACK - c->margin);
    double cells = (double)__builtin_popcountll(found->cells & table->cells[code]) /
                   (double)__builtin_popcountll(table->cells[code]);
    if (c->is_cloud) { // no holes, and no pixels
        return cells >= FULL_CELLS ? code : STP_COVERAGE_WHOLE;
    }
    bool corner = stp_stencil_is_solid(&c->p->stencil, found->cells);
    double hit = (double)__builtin_popcountll(found->cells & c->p->stencil.disk) /
                 (double)__builtin_popcountll(c->p->stencil.disk);
    hit = hit < (double)table->areas[code] ? hit : (double)table->areas[code];
    double area = ray_share(c, found) / hit;
    double agreement = (double)(found->area / found->total);
    double facing_part = ramp(agreement, OPEN_FACING, FULL_FACING);
    double solid = fmax(corner ? facing_part : 0.0, ramp(cells, OPEN_CELLS, FULL_CELLS));
    if ((double)table->areas[code] < NARROW) { // few samples lie in there
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
    return stp_coverage_of_share(
        share * solid + thin_share(c, surfel, (double)found->area / c->disk) * (1.0 - solid));
}

static stp_result look_around(const chooser* c, const uint32_t* doubtful, size_t count,
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
    float asked = stp_max(p->cuts.farthest + SLACK - c->margin, 0.0f);
    search.reach_asked = asked * asked * 1.0001f; // what reaches farther is drawn whole
    // few samples, or points, which do not lie in rows: their squares are twice as wide, so that they close up
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
        found != NULL ? look_around(c, doubtful, count, found) : stp_fail_memory(context);
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
    return !(c->pixel_size > 0.0) || (c->direction_count == 0 && spacings < STP_LEAST_SPACINGS);
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
