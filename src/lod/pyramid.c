// SPDX-License-Identifier: MIT
//
// The colour pyramid and coverage, from the finest octave to the coarsest.
//
// Finest: each candidate belongs to the nearest surfel on its side; a surfel's colour is the
// average of its candidates. Coarser: each surfel of an octave's prefix belongs to the nearest of
// the next coarser prefix. Surfels of one prefix lie evenly, so each stands for the same area, less
// what of its disk is no surface: that is the weight. All sums are of whole numbers, and so do not
// depend on the order of threads.
#include "base/color.h"
#include "lod/finish.h"
#include "lod/neighbours.h"
#include "lod/stencil.h"

#include <string.h>

#define LINEAR_ONE 1048576.0f // linear light as whole numbers: 1 is 2^20
// Surfels that sample a disk cover to an eighth of its radius: then each cell of the stencil, a quarter wide,
// that is full of surface holds at least one.
#define SAMPLE_RADIUS 0.125f
// Where candidates do, each stands for up to so much of a disk's pixels.
#define DISK_CANDIDATES 32.0
// Half the side of a square over the radius of a disk as large.
#define DISK_SQUARE 0.88622693f
// Surfels of sets say by their opacity how much of them is surface: their number says nothing, and is made so large
// that it never counts.
#define SET_WEIGHT 1024u
// Cells that a disk reaches to each side; only orders that leave huge gaps would go beyond.
#define MOST_CELLS 12.0f
// Part of a fraction seen that is taken for true, whatever was counted.
#define LEAST_BELIEVED 0.4
#define AHEAD 24u // samples that memory is asked for in advance

// One entry of the pyramid.
typedef struct entry {
    uint32_t color[3]; ///< linear, LINEAR_ONE is 1
    uint16_t alpha;    ///< mean opacity, 65535 is 1
    uint16_t fraction; ///< how much of the disk is surface, opacity included, 65535 is 1
} entry;

typedef struct entry_sum {
    uint64_t color[3], alpha, weight, count;
} entry_sum;

typedef struct pyramid {
    stp_context* context;
    const stp_pyramid_input* input;
    stp_surfels* surfels;
    stp_stencil stencil;
    uint32_t linear[256];
    entry* octaves[STP_OCTAVE_LIMIT];      ///< entries of each octave, in one array
    uint16_t* fractions[STP_OCTAVE_LIMIT]; ///< the same fractions, as columns for searches
    entry* entries;
    uint16_t* fraction_column;
    entry_sum* sums;
    stp_grid candidates; ///< all, in cells made for the finest octave
    uint32_t* nearest;   ///< of each sample, in its grid's order
    stp_disk* disks;
    uint32_t* spatial; ///< all surfels along a space-filling curve
    uint32_t* visit;   ///< those of one prefix
} pyramid;

// The shortest prefix dense enough to sample the disks of an octave; 0 where there is none:
// candidates are.
static uint32_t sample_count(const pyramid* p, float radius)
{
    const float* envelope = p->input->envelope;
    uint32_t low = 1,
             high = p->surfels->count; // the first index at which the envelope is small enough
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (envelope[middle] <= radius * SAMPLE_RADIUS) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    bool all = low == p->surfels->count;
    return all && p->input->finish->final_radius > radius * SAMPLE_RADIUS ? 0 : low;
}

static uint16_t to_fraction(double value)
{
    return (uint16_t)(value * 65535.0 + 0.5);
}

static void add_sample(entry_sum* sum, const uint32_t color[3], uint64_t weight, uint64_t alpha)
{
    for (int k = 0; k < 3; ++k) {
        sum->color[k] += weight * color[k];
    }
    sum->weight += weight;
    sum->alpha += alpha;
    sum->count += 1;
}

static void add_candidates(pyramid* p, const stp_grid* samples)
{
    const uint8_t* colors = p->input->finish->candidates->colors;
    for (uint32_t at = 0; at < samples->count; ++at) {
        if (at + AHEAD < samples->count) {
            __builtin_prefetch(colors + 4 * (size_t)samples->index[at + AHEAD]);
            __builtin_prefetch(&p->sums[p->nearest[at + AHEAD] & INT32_MAX]);
        }
        if (p->nearest[at] != UINT32_MAX) {
            const uint8_t* c = colors + 4 * (size_t)samples->index[at];
            uint32_t color[3] = {p->linear[c[0]], p->linear[c[1]], p->linear[c[2]]};
            uint64_t weight = c[3] > 0 ? c[3] : 1; // what is nearly clear has little say
            add_sample(&p->sums[p->nearest[at]], color, weight, c[3]);
        }
    }
}

static void add_surfels(pyramid* p, const stp_grid* samples, const entry* finer)
{
    for (uint32_t at = 0; at < samples->count; ++at) {
        const entry* e = &finer[samples->index[at]];
        if (p->nearest[at] != UINT32_MAX) {
            add_sample(&p->sums[p->nearest[at]], e->color, e->fraction > 0 ? e->fraction : 1,
                       e->alpha);
        }
    }
}

// The entry of a surfel to which nothing was assigned: what stood there before.
static entry single_entry(const pyramid* p, const entry* finer, uint32_t surfel)
{
    if (finer != NULL) {
        return finer[surfel];
    }
    const uint8_t* c =
        p->input->finish->candidates->colors + 4 * (size_t)p->input->finish->order[surfel];
    return (entry){.color = {p->linear[c[0]], p->linear[c[1]], p->linear[c[2]]},
                   .alpha = to_fraction((double)c[3] / 255.0)};
}

// Averages what was added. `alpha_one`: the sum of alphas that means 1 for a single sample.
static void average_octave(pyramid* p, uint32_t octave, const entry* finer, uint32_t alpha_one)
{
    uint32_t count = p->surfels->octave_ends[octave];
    for (uint32_t i = 0; i < count; ++i) {
        const entry_sum* sum = &p->sums[i];
        entry* e = &p->octaves[octave][i];
        if (sum->count == 0) {
            *e = single_entry(p, finer, i);
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            e->color[k] = (uint32_t)((sum->color[k] + sum->weight / 2) / sum->weight);
        }
        uint64_t one = sum->count * alpha_one;
        e->alpha = (uint16_t)((sum->alpha * 65535 + one / 2) / one);
    }
}

static void set_fraction(pyramid* p, uint32_t octave, uint32_t surfel, double fraction)
{
    p->octaves[octave][surfel].fraction = to_fraction(fraction);
    p->fractions[octave][surfel] = p->octaves[octave][surfel].fraction;
}

static double opacity(const entry* e)
{
    return (double)e->alpha / 65535.0;
}

// How many candidates a piece of surface of one square pixel has, as seen by all views that face it.
static double usual_density(const stp_candidates* candidates)
{
    return candidates->direction_count != 0 ? 0.25 * candidates->direction_count : 1.0;
}

// Octaves whose disks were sampled by every stride-th candidate. Their squares make thin things look too wide, and
// their number tells better; but things may be hidden from some views, so the number alone is not believed either.
static void cover_captured(pyramid* p, uint32_t octave, double pixels, uint32_t stride)
{
    double full_count = usual_density(p->input->finish->candidates) * pixels / stride;
    double believed = LEAST_BELIEVED / sqrt((double)stride);
    for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
        double fraction = (double)stp_stencil_fraction(&p->stencil, p->disks[i].cells);
        if (fraction < 1.0) {
            double counted = (double)p->disks[i].count / full_count;
            counted = counted < fraction * believed ? fraction * believed : counted;
            fraction = counted < fraction ? counted : fraction;
        }
        set_fraction(p, octave, i, fraction * opacity(&p->octaves[octave][i]));
    }
}

// Octaves whose disks were sampled by surfels: what is hit counts by their mean fraction.
static void cover_sampled(pyramid* p, uint32_t octave)
{
    for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
        const stp_disk* disk = &p->disks[i];
        double fraction = (double)stp_stencil_fraction(&p->stencil, disk->cells);
        fraction *=
            disk->count != 0 ? (double)disk->fractions / ((double)disk->count * 65535.0) : 1.0;
        set_fraction(p, octave, i, fraction);
    }
}

// How an octave is made.
typedef struct octave_plan {
    float radius;         ///< to what its prefix covers
    float disk_radius;    ///< of the disks drawn with it
    uint32_t dense_count; ///< surfels that sample the disks; 0: every stride-th candidate does
    uint32_t stride;
    float cell; ///< of the grids
} octave_plan;

static float pixel_size(const pyramid* p)
{
    return (float)p->input->finish->candidates->pixel_size;
}

// The area of a disk in pixels of the capture.
static double disk_pixels(const pyramid* p, float radius)
{
    double pixels = pixel_size(p) > 0.0f ? (double)(radius / pixel_size(p)) : 1.0;
    return STP_PI * pixels * pixels;
}

// How much wider the squares of every stride-th are. A thinned grid takes as many of each place: their gaps are more
// alike than those of all, and squares a little less wide close them.
static float widen(uint32_t stride)
{
    return stride > 1 ? sqrtf((float)stride * 0.75f) : 1.0f;
}

// Half the side of the square that a captured candidate stands for. A pixel is up to 1.7 times as wide along a slope
// as across: squares of twice its width leave no gaps.
static float pixel_footprint(const pyramid* p, const octave_plan* plan)
{
    return stp_min(pixel_size(p) * widen(plan->stride), plan->disk_radius);
}

// The same of a surfel of a set: the square is as large as its disk.
static float set_footprint(const pyramid* p, const octave_plan* plan)
{
    float side = p->input->finish->candidates->set_radius * DISK_SQUARE;
    return stp_min(side * widen(plan->stride), plan->disk_radius);
}

static float candidate_footprint(const pyramid* p, const octave_plan* plan)
{
    const stp_candidates* c = p->input->finish->candidates;
    float largest = c->set_count < c->count ? pixel_footprint(p, plan) : 0.0f;
    return c->set_count != 0 ? stp_max(largest, set_footprint(p, plan)) : largest;
}

static stp_result plan_octave(const pyramid* p, uint32_t octave, octave_plan* plan)
{
    const stp_surfels* s = p->surfels;
    uint32_t count = s->octave_ends[octave];
    bool finest = octave + 1 == s->octave_count;
    plan->radius = finest ? p->input->finish->final_radius : p->input->envelope[count];
    plan->disk_radius = stp_max(plan->radius + p->input->candidate_radius, s->step);
    uint32_t dense = finest ? 0 : sample_count(p, plan->radius);
    plan->dense_count = !finest && dense >= s->octave_ends[octave + 1] ? dense : 0;
    double stride = ceil(disk_pixels(p, plan->disk_radius) / DISK_CANDIDATES);
    plan->stride = finest || stride < 1.0 ? 1 : stride > 64.0 ? 64 : (uint32_t)stride;
    // wide enough that few cells surround a disk
    float wide = plan->disk_radius + (plan->dense_count != 0 ? 0.0f : candidate_footprint(p, plan));
    float cell = stp_max(2.002f * plan->radius, wide);
    stp_result result =
        stp_grid_choose_cell(p->context, p->input->positions, count, cell, &plan->cell);
    plan->radius = stp_min(plan->radius, plan->cell * 0.4995f);
    return result;
}

static void find_nearest(pyramid* p, const octave_plan* plan, const stp_grid* surfels,
                         const stp_grid* samples)
{
    stp_nearest_search search = {.surfels = surfels,
                                 .samples = samples,
                                 .radius = plan->radius * 1.0001f,
                                 .two_sided = p->input->finish->two_sided,
                                 .nearest = p->nearest};
    stp_nearest_search_run(p->context, &search);
}

// Lists the surfels of a prefix along the curve.
static uint32_t list_prefix(pyramid* p, uint32_t count)
{
    uint32_t listed = 0;
    for (uint32_t i = 0; i < p->surfels->count; ++i) {
        if (p->spatial[i] < count) {
            p->visit[listed++] = p->spatial[i];
        }
    }
    return listed;
}

static stp_disk_search begin_disk_search(pyramid* p, uint32_t octave, const octave_plan* plan,
                                         const stp_grid* samples)
{
    return (stp_disk_search){
        .samples = samples,
        .positions = p->input->positions,
        .normals = p->input->normals,
        .visit = p->visit,
        .count = list_prefix(p, p->surfels->octave_ends[octave]),
        .radius = stp_min(plan->disk_radius, MOST_CELLS * samples->cell),
        .two_sided = p->input->finish->two_sided,
        .stencil = &p->stencil,
        .disks = p->disks,
    };
}

static void look_at_surfels(pyramid* p, uint32_t octave, const octave_plan* plan,
                            const stp_grid* samples)
{
    stp_disk_search search = begin_disk_search(p, octave, plan, samples);
    uint32_t finer = octave + 1;
    while (p->surfels->octave_ends[finer] < plan->dense_count) {
        finer += 1;
    }
    search.fractions = p->fractions[finer];
    stp_disk_search_run(p->context, &search);
    cover_sampled(p, octave);
}

static void look_at_candidates(pyramid* p, uint32_t octave, const octave_plan* plan,
                               const stp_grid* samples)
{
    stp_disk_search search = begin_disk_search(p, octave, plan, samples);
    const stp_candidates* c = p->input->finish->candidates;
    search.footprint = candidate_footprint(p, plan);
    search.sample_count = c->count;
    search.set_count = c->set_count;
    search.set_footprint = set_footprint(p, plan);
    search.set_weight = SET_WEIGHT;
    search.until_solid = true;
    stp_disk_search_run(p->context, &search);
    cover_captured(p, octave, disk_pixels(p, search.radius), plan->stride);
}

static stp_result look_at_some_candidates(pyramid* p, uint32_t octave, const octave_plan* plan)
{
    float cell = plan->disk_radius + candidate_footprint(p, plan);
    if (plan->stride == 1 && cell <= MOST_CELLS * p->candidates.cell) {
        look_at_candidates(p, octave, plan, &p->candidates);
        return STP_OK;
    }
    stp_grid samples;
    stp_result result = stp_grid_thin(p->context, &p->candidates, plan->stride, cell, &samples);
    if (result == STP_OK) {
        look_at_candidates(p, octave, plan, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

// The finest octave: colours of candidates.
static stp_result make_finest(pyramid* p, uint32_t octave, const octave_plan* plan,
                              const stp_grid* surfels)
{
    const stp_candidates* c = p->input->finish->candidates;
    stp_result result = stp_grid_create(p->context, c->positions, c->normals, c->count, plan->cell,
                                        0.5f * plan->cell, &p->candidates);
    if (result == STP_OK) {
        find_nearest(p, plan, surfels, &p->candidates);
        add_candidates(p, &p->candidates);
        average_octave(p, octave, NULL, 255);
        look_at_candidates(p, octave, plan, &p->candidates);
    }
    return result;
}

static stp_result look_at_dense_surfels(pyramid* p, uint32_t octave, const octave_plan* plan)
{
    stp_grid samples;
    stp_result result = stp_grid_create(p->context, p->input->positions, p->input->normals,
                                        plan->dense_count, plan->cell, 0.0f, &samples);
    if (result == STP_OK) {
        look_at_surfels(p, octave, plan, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

// The others: colours of the next finer octave.
static stp_result make_coarser(pyramid* p, uint32_t octave, const octave_plan* plan,
                               const stp_grid* surfels)
{
    stp_grid samples;
    stp_result result = stp_grid_create(p->context, p->input->positions, p->input->normals,
                                        p->surfels->octave_ends[octave + 1], plan->cell,
                                        0.5f * plan->cell, &samples);
    if (result != STP_OK) {
        return result;
    }
    find_nearest(p, plan, surfels, &samples);
    add_surfels(p, &samples, p->octaves[octave + 1]);
    average_octave(p, octave, p->octaves[octave + 1], 65535);
    stp_grid_destroy(p->context, &samples);
    return plan->dense_count != 0 ? look_at_dense_surfels(p, octave, plan)
                                  : look_at_some_candidates(p, octave, plan);
}

static stp_result make_octave(pyramid* p, uint32_t octave)
{
    uint32_t count = p->surfels->octave_ends[octave];
    memset(p->sums, 0, count * sizeof(*p->sums));
    octave_plan plan;
    stp_grid surfels;
    stp_result result = plan_octave(p, octave, &plan);
    if (result == STP_OK) {
        result = stp_grid_create(p->context, p->input->positions, p->input->normals, count,
                                 plan.cell, 0.0f, &surfels);
    }
    if (result != STP_OK) {
        return result;
    }
    bool finest = octave + 1 == p->surfels->octave_count;
    result =
        finest ? make_finest(p, octave, &plan, &surfels) : make_coarser(p, octave, &plan, &surfels);
    stp_grid_destroy(p->context, &surfels);
    return result;
}

// Disks of one prefix overlap about twice, so each is drawn with a chance whose union is the
// fraction.
static uint8_t encode_coverage(uint16_t fraction)
{
    double chance = 1.0 - sqrt(1.0 - (double)fraction / 65535.0);
    int code = (int)(chance * 255.0 + 0.5);
    return (uint8_t)(code < 1 ? 1 : code);
}

static void write_octaves(pyramid* p)
{
    size_t at = 0;
    for (uint32_t octave = 0; octave < p->surfels->octave_count; ++octave) {
        for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i, ++at) {
            const entry* e = &p->octaves[octave][i];
            for (int k = 0; k < 3; ++k) {
                p->surfels->colors[3 * at + (size_t)k] =
                    stp_linear_to_srgb8((float)e->color[k] / LINEAR_ONE);
            }
            p->surfels->coverages[at] = encode_coverage(e->fraction);
        }
    }
}

static stp_result allocate_pyramid(pyramid* p)
{
    const stp_surfels* s = p->surfels;
    size_t total = 0, count = s->count, samples = p->input->finish->candidates->count;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        total += s->octave_ends[i];
    }
    p->entries = STP_NEW_ARRAY(p->context, entry, total);
    p->fraction_column = STP_NEW_ARRAY(p->context, uint16_t, total);
    p->sums = STP_NEW_ARRAY(p->context, entry_sum, count);
    p->nearest = STP_NEW_ARRAY(p->context, uint32_t, samples > count ? samples : count);
    p->disks = STP_NEW_ARRAY(p->context, stp_disk, count);
    p->spatial = STP_NEW_ARRAY(p->context, uint32_t, count);
    p->visit = STP_NEW_ARRAY(p->context, uint32_t, count);
    if (p->entries == NULL || p->fraction_column == NULL || p->sums == NULL || p->nearest == NULL ||
        p->disks == NULL || p->spatial == NULL || p->visit == NULL) {
        return stp_fail_memory(p->context);
    }
    total = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        p->octaves[i] = p->entries + total;
        p->fractions[i] = p->fraction_column + total;
        total += s->octave_ends[i];
    }
    return STP_OK;
}

static void free_pyramid(pyramid* p)
{
    stp_grid_destroy(p->context, &p->candidates);
    stp_free(p->context, p->visit);
    stp_free(p->context, p->spatial);
    stp_free(p->context, p->disks);
    stp_free(p->context, p->nearest);
    stp_free(p->context, p->sums);
    stp_free(p->context, p->fraction_column);
    stp_free(p->context, p->entries);
}

stp_result stp_make_pyramid(stp_context* context, const stp_pyramid_input* input,
                            stp_surfels* surfels)
{
    pyramid p = {
        .context = context, .input = input, .surfels = surfels, .stencil = stp_stencil_make()};
    for (int i = 0; i < 256; ++i) {
        p.linear[i] = (uint32_t)(stp_srgb8_to_linear((uint8_t)i) * LINEAR_ONE + 0.5f);
    }
    stp_result result = allocate_pyramid(&p);
    if (result == STP_OK) {
        result = stp_sort_spatially(context, input->positions, surfels->count, p.spatial);
    }
    for (uint32_t octave = surfels->octave_count; result == STP_OK && octave > 0; --octave) {
        uint32_t done = surfels->octave_count - octave;
        result = stp_progress(context, "finish", (double)done / (double)surfels->octave_count);
        if (result == STP_OK) {
            result = make_octave(&p, octave - 1);
        }
    }
    if (result == STP_OK) {
        write_octaves(&p);
    }
    free_pyramid(&p);
    return result;
}
