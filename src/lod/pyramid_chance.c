// SPDX-License-Identifier: MIT
//
// The chance with which a disk's pixel is drawn. Disks of a surface overlap and hide what lies behind: they are drawn
// whole. Disks of what is thin or small stand far over it: of theirs only so many pixels are drawn as the surface
// nearest to the surfel would cover, so that wires, lattices and far trees keep their area, however large the disks.
// How much surface is nearest to each surfel is counted with the colours: pixels of the capture that belong to it.
#include "lod/pyramid.h"

// Of the surface that is nearest to surfels of whole surfaces, disks that stand alone have less than the first part;
// those with more than the second are drawn whole: surface that half of the views do not see has so much.
#define THIN 0.3
#define WHOLE 0.5
// Of the finest octave less, and its sectors are not looked at: a dozen candidates in a disk do not tell a wire from a border.
#define THIN_OF_FINEST 0.08
#define WHOLE_OF_FINEST 0.18
// Surface that on the mean faces away by more than this cosine is something else: the ground below a tree.
#define LEAST_FACING 0.3
// No surfel of a whole surface has less, even at a corner: another lies as far away as the disks reach.
#define CORNER 0.1
// Disks whose fullest quarter has more than the first part are no wires; with more than the second they are whole.
#define THIN_QUARTER 0.55
#define WHOLE_QUARTER 0.7
// Sectors are looked at in surfels of so many octaves further down: about forty lie in a disk.
#define SAMPLE_OCTAVES 2u
// Even where surfels lie closer, disks are looked at as if they reached so many pixels.
#define LEAST_REACH 0.5f

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

static double clamp(double value)
{
    return value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value;
}

static double ramp(double value, double low, double high)
{
    return clamp((value - low) / (high - low));
}

// How much of the surface nearest to a surfel faces as it does: the mean cosine.
static double facing(const stp_pyramid* p, const stp_pyramid_entry* e, uint32_t surfel)
{
    const float* n = p->input->normals + 3 * (size_t)surfel;
    double along = (double)n[0] * (double)e->toward[0] + (double)n[1] * (double)e->toward[1] +
                   (double)n[2] * (double)e->toward[2];
    return e->area > 0.0f ? clamp(along / (double)e->area) : 0.0;
}

// Disks of one prefix overlap about twice, so each is drawn with a chance whose union is the fraction.
static double overlapping_chance(uint16_t fraction)
{
    return 1.0 - sqrt(1.0 - (double)fraction / 65535.0);
}

// How much of the nearest surface is taken for the surfel's own.
static double own_part(double cosine)
{
    double part = clamp(cosine / LEAST_FACING);
    return part * part * part * part;
}

static uint8_t encode(double chance)
{
    int code = (int)(chance * 255.0 + 0.5);
    return (uint8_t)(code < 1 ? 1 : code > 255 ? 255 : code);
}

// What an octave's chances are chosen by. Lengths are in scene units, areas in STP_AREA_UNITS.
typedef struct chooser {
    stp_pyramid* p;
    uint32_t octave;
    stp_pyramid_entry* entries;
    uint32_t stride;          ///< of the candidates that are looked at
    float reach, disk_radius; ///< to what the prefix covers; of the disks
    double disk, whole;       ///< areas: of a disk; nearest to a surfel of a whole surface
} chooser;

static chooser make_chooser(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    float pixel = (float)p->input->finish->candidates->pixel_size;
    float reach = stp_max(plan->radius, LEAST_REACH * pixel);
    double pixels = (double)(reach / pixel), disk = (double)(plan->disk_radius / pixel);
    return (chooser){
        .p = p,
        .octave = octave,
        .entries = p->octaves[octave],
        .reach = reach,
        .disk_radius = plan->disk_radius,
        .stride = plan->stride,
        .disk = STP_PI * disk * disk * STP_AREA_UNITS,
        .whole = STP_WHOLE_SHARE * STP_PI * pixels * pixels * STP_AREA_UNITS,
    };
}

// A coverage between that of a disk that is whole, and that of one that stands over what is thin. `solid`: 0..1
static uint8_t choose(const chooser* c, uint32_t surfel, double solid)
{
    const stp_pyramid_entry* e = &c->entries[surfel];
    double whole = overlapping_chance(e->fraction);
    double own = own_part(facing(c->p, e, surfel));
    double alpha =
        c->p->input->finish->candidates->set_count != 0 ? 1.0 : (double)e->alpha / 65535.0;
    double thin = stp_chance_of_share((double)e->area * own / c->disk) * alpha;
    thin = thin < whole ? thin : whole;
    return encode(whole * solid + thin * (1.0 - solid));
}

// Chooses by what is nearest to each surfel. @return how many are in doubt; they are listed, along the curve
static size_t choose_by_area(const chooser* c, uint32_t* doubtful)
{
    size_t count = 0;
    bool finest = c->octave + 1 == c->p->surfels->octave_count;
    double low = finest ? THIN_OF_FINEST : THIN, high = finest ? WHOLE_OF_FINEST : WHOLE;
    for (uint32_t at = 0; at < c->p->visit_count; ++at) {
        uint32_t i = c->p->visit[at];
        stp_pyramid_entry* e = &c->entries[i];
        double cosine = facing(c->p, e, i);
        double share = (double)e->area * cosine * cosine / c->whole;
        e->coverage = choose(c, i, ramp(share, low, high));
        bool lower = e->coverage < encode(overlapping_chance(e->fraction));
        if (!finest && lower && (double)e->area >= CORNER * c->whole) {
            doubtful[count++] = i;
        }
    }
    return count;
}

static void choose_by_sectors(const chooser* c, const stp_sector_search* search)
{
    double pixels = (double)search->radius / c->p->input->finish->candidates->pixel_size;
    double quarter = 0.25 * STP_PI * pixels * pixels * STP_AREA_UNITS;
    for (size_t i = 0; i < search->count; ++i) {
        uint32_t surfel = search->visit[i];
        uint8_t coverage = choose(
            c, surfel, ramp((double)search->fullest[i] / quarter, THIN_QUARTER, WHOLE_QUARTER));
        uint8_t* before = &c->entries[surfel].coverage;
        *before = coverage > *before ? coverage : *before;
    }
}

static void run_search(const chooser* c, stp_sector_search* search, const stp_grid* samples)
{
    search->samples = samples;
    search->radius = stp_min(search->radius, samples->cell);
    stp_sector_search_run(c->p->context, search);
}

// The last octave but one has no octave of surfels dense enough: candidates tell.
static stp_result look_at_candidates(const chooser* c, stp_sector_search* search)
{
    stp_pyramid* p = c->p;
    search->radius = c->disk_radius;
    stp_grid samples;
    stp_result result =
        stp_grid_thin(p->context, &p->candidates, c->stride, c->disk_radius * 1.001f, &samples);
    if (result == STP_OK) {
        search->stride = c->stride;
        run_search(c, search, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

static stp_result look_at_surfels(const chooser* c, stp_sector_search* search, uint32_t finer)
{
    stp_pyramid* p = c->p;
    stp_grid samples;
    stp_result result =
        stp_grid_create(p->context, p->input->positions, p->input->normals,
                        p->surfels->octave_ends[finer], c->reach * 1.001f, 0.0f, &samples);
    if (result == STP_OK) {
        search->entries = p->octaves[finer];
        search->radius = c->reach;
        run_search(c, search, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

static stp_result look_at_sectors(const chooser* c, stp_sector_search* search)
{
    uint32_t finer = c->octave + SAMPLE_OCTAVES;
    return finer < c->p->surfels->octave_count ? look_at_surfels(c, search, finer)
                                               : look_at_candidates(c, search);
}

static stp_result choose_all(const chooser* c, uint32_t* doubtful, float* fullest)
{
    stp_sector_search search = {
        .pyramid = c->p, .stride = 1, .visit = doubtful, .fullest = fullest};
    search.count = choose_by_area(c, doubtful);
    stp_result result = search.count != 0 ? look_at_sectors(c, &search) : STP_OK;
    if (result == STP_OK) {
        choose_by_sectors(c, &search);
    }
    return result;
}

stp_result stp_pyramid_choose_chances(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    const stp_candidates* candidates = p->input->finish->candidates;
    uint32_t count = p->surfels->octave_ends[octave];
    if (candidates->direction_count == 0 || !(candidates->pixel_size > 0.0)) { // points: no pixels
        for (uint32_t i = 0; i < count; ++i) {
            stp_pyramid_entry* e = &p->octaves[octave][i];
            e->coverage = encode(overlapping_chance(e->fraction));
        }
        return STP_OK;
    }
    chooser c = make_chooser(p, octave, plan);
    uint32_t* doubtful = STP_NEW_ARRAY(p->context, uint32_t, count);
    float* fullest = STP_NEW_ARRAY(p->context, float, count);
    stp_result result = doubtful != NULL && fullest != NULL ? choose_all(&c, doubtful, fullest)
                                                            : stp_fail_memory(p->context);
    stp_free(p->context, fullest);
    stp_free(p->context, doubtful);
    return result;
}
