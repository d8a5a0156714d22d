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
#define CELL_CANDIDATES                                                                            \
    75.0 // where candidates do, each stands for up to so many of the disk's pixels
#define LEAST_BELIEVED 0.4 // part of a fraction seen that is taken for true, whatever was counted

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
    float* frames;                         ///< two tangents a surfel
    entry* octaves[STP_OCTAVE_LIMIT];      ///< entries of each octave, in one array
    uint16_t* fractions[STP_OCTAVE_LIMIT]; ///< the same fractions, as columns for walks
    entry* entries;
    uint16_t* fraction_column;
    entry_sum* sums;
    uint32_t* nearest; ///< of each sample of the walk made last
    void* disk_memory;
    _Atomic uint64_t* disks;
    _Atomic uint64_t* disk_sums;
} pyramid;

static void make_frames(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    pyramid* p = user;
    for (size_t i = begin; i < end; ++i) {
        const float* n = p->input->normals + 3 * i;
        stp_vec3 normal = {n[0], n[1], n[2]};
        float x = fabsf(n[0]), y = fabsf(n[1]), z = fabsf(n[2]);
        stp_vec3 axis = {x <= y && x <= z, y < x && y <= z, z < x && z < y};
        stp_vec3 first = stp_normalize(stp_cross(normal, axis));
        stp_vec3 second = stp_cross(normal, first);
        float* frame = p->frames + 6 * i;
        frame[0] = first.x, frame[1] = first.y, frame[2] = first.z;
        frame[3] = second.x, frame[4] = second.y, frame[5] = second.z;
    }
}

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

static void add_candidates(pyramid* p)
{
    const stp_candidates* candidates = p->input->finish->candidates;
    for (uint32_t i = 0; i < candidates->count; ++i) {
        if (p->nearest[i] != UINT32_MAX) {
            const uint8_t* c = candidates->colors + 4 * (size_t)i;
            entry_sum* sum = &p->sums[p->nearest[i]];
            uint64_t weight = c[3] > 0 ? c[3] : 1; // what is nearly clear has little say
            for (int k = 0; k < 3; ++k) {
                sum->color[k] += weight * p->linear[c[k]];
            }
            sum->weight += weight;
            sum->alpha += c[3];
            sum->count += 1;
        }
    }
}

static void add_surfels(pyramid* p, const entry* finer, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        if (p->nearest[i] != UINT32_MAX) {
            entry_sum* sum = &p->sums[p->nearest[i]];
            uint64_t weight = finer[i].fraction > 0 ? finer[i].fraction : 1;
            for (int k = 0; k < 3; ++k) {
                sum->color[k] += weight * finer[i].color[k];
            }
            sum->weight += weight;
            sum->alpha += finer[i].alpha;
            sum->count += 1;
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

// The sum a walk left for one surfel.
typedef struct disk_sum {
    uint64_t count, total;
} disk_sum;

static disk_sum read_sum(const pyramid* p, uint32_t surfel)
{
    uint64_t sum = p->disk_sums[surfel];
    return (disk_sum){sum >> STP_SUM_SHIFT, sum & (((uint64_t)1 << STP_SUM_SHIFT) - 1)};
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

// Octaves whose disks were sampled by candidates. Their squares make thin things look too wide, and their number
// tells better; but things may be hidden from some views, so the number alone is not believed either.
static void cover_captured(pyramid* p, uint32_t octave, double disk_pixels, uint32_t stride)
{
    double full_count = usual_density(p->input->finish->candidates) * disk_pixels / stride;
    double believed = LEAST_BELIEVED / sqrt((double)stride);
    for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
        double fraction = (double)stp_stencil_fraction(&p->stencil, p->disks[i]);
        if (fraction < 1.0) {
            double counted = (double)read_sum(p, i).count / full_count;
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
        double fraction = (double)stp_stencil_fraction(&p->stencil, p->disks[i]);
        disk_sum sum = read_sum(p, i);
        fraction *= sum.count != 0 ? (double)sum.total / ((double)sum.count * 65535.0) : 1.0;
        set_fraction(p, octave, i, fraction);
    }
}

static uint32_t choose_stride(double disk_pixels)
{
    double stride = disk_pixels / CELL_CANDIDATES;
    return stride < 1.0 ? 1 : stride > 64.0 ? 64 : (uint32_t)stride;
}

// Every stride-th candidate stands for as many pixels.
static void stretch_footprint(stp_neighbour_walk* walk, uint32_t stride)
{
    walk->stride = stride;
    walk->footprint *= sqrtf((float)stride);
    walk->footprint = stp_min(walk->footprint, walk->grid->reach - walk->disk_radius);
}

static void average_surfels(pyramid* p, uint32_t octave)
{
    const entry* finer = p->octaves[octave + 1];
    add_surfels(p, finer, p->surfels->octave_ends[octave + 1]);
    average_octave(p, octave, finer, 65535);
}

// Walks over the samples of one octave's cells and disks, and makes its entries.
static void make_entries(pyramid* p, uint32_t octave, const stp_neighbour_walk* common,
                         float radius)
{
    const stp_surfels* s = p->surfels;
    const stp_candidates* candidates = p->input->finish->candidates;
    double pixel =
        candidates->pixel_size > 0.0 ? candidates->pixel_size : (double)common->disk_radius;
    double pixels = (double)common->disk_radius / pixel, disk_pixels = STP_PI * pixels * pixels;
    stp_neighbour_walk captured = *common, surfels = *common;
    captured.positions = candidates->positions;
    captured.normals = candidates->normals;
    captured.count = candidates->count;
    surfels.positions = p->input->positions;
    surfels.normals = p->input->normals;
    surfels.nearest = p->nearest;
    surfels.footprint = 0.0f;
    if (octave + 1 == s->octave_count) {
        captured.nearest = p->nearest;
        stp_neighbour_walk_run(p->context, &captured);
        add_candidates(p);
        average_octave(p, octave, NULL, 255);
        cover_captured(p, octave, disk_pixels, 1);
        return;
    }
    uint32_t samples = sample_count(p, radius);
    if (samples < s->octave_ends[octave + 1]) {
        surfels.count = s->octave_ends[octave + 1];
        surfels.frames = NULL;
        stp_neighbour_walk_run(p->context, &surfels);
        average_surfels(p, octave);
        stretch_footprint(&captured, choose_stride(disk_pixels));
        stp_neighbour_walk_run(p->context, &captured);
        cover_captured(p, octave, disk_pixels, captured.stride);
        return;
    }
    uint32_t finer = octave + 1;
    while (s->octave_ends[finer] < samples) {
        finer += 1;
    }
    surfels.count = samples;
    surfels.fractions = p->fractions[finer];
    surfels.disk_cells = UINT64_MAX; // means are wanted, of full disks too
    stp_neighbour_walk_run(p->context, &surfels);
    average_surfels(p, octave);
    cover_sampled(p, octave);
}

static stp_result make_octave(pyramid* p, uint32_t octave)
{
    uint32_t count = p->surfels->octave_ends[octave];
    bool last = octave + 1 == p->surfels->octave_count;
    float radius = last ? p->input->finish->final_radius : p->input->envelope[count];
    float disk_radius = stp_max(radius + p->input->candidate_radius, p->surfels->step);
    stp_grid grid;
    stp_result result = stp_grid_create(p->context, p->input->positions, p->input->normals, count,
                                        1.5f * disk_radius, &grid);
    if (result != STP_OK) {
        return result;
    }
    memset(p->sums, 0, count * sizeof(*p->sums));
    for (uint32_t i = 0; i < count; ++i) {
        atomic_store_explicit(&p->disks[i], 0, memory_order_relaxed);
        atomic_store_explicit(&p->disk_sums[i], 0, memory_order_relaxed);
    }
    // a pixel is up to 1.7 times as wide along a slope as across: squares of twice its width leave no gaps
    float footprint = (float)p->input->finish->candidates->pixel_size;
    stp_neighbour_walk walk = {
        .grid = &grid,
        .stride = 1,
        .footprint = stp_min(footprint, 0.33f * grid.reach),
        .frames = p->frames,
        .disk_radius = stp_min(disk_radius, 0.67f * grid.reach),
        .disk_cells = p->stencil.disk,
        .nearest_radius = stp_min(radius * 1.0001f, grid.reach),
        .two_sided = p->input->finish->two_sided,
        .disks = p->disks,
        .sums = p->disk_sums,
    };
    make_entries(p, octave, &walk, radius);
    stp_grid_destroy(p->context, &grid);
    return STP_OK;
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
    p->frames = STP_NEW_ARRAY(p->context, float, 6 * count);
    p->entries = STP_NEW_ARRAY(p->context, entry, total);
    p->fraction_column = STP_NEW_ARRAY(p->context, uint16_t, total);
    p->sums = STP_NEW_ARRAY(p->context, entry_sum, count);
    p->nearest = STP_NEW_ARRAY(p->context, uint32_t, samples > count ? samples : count);
    p->disk_memory = stp_alloc_array(p->context, 2 * count, sizeof(*p->disks));
    if (p->frames == NULL || p->entries == NULL || p->fraction_column == NULL || p->sums == NULL ||
        p->nearest == NULL || p->disk_memory == NULL) {
        return stp_fail_memory(p->context);
    }
    p->disks = p->disk_memory;
    p->disk_sums = p->disks + count;
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
    stp_free(p->context, p->disk_memory);
    stp_free(p->context, p->nearest);
    stp_free(p->context, p->sums);
    stp_free(p->context, p->fraction_column);
    stp_free(p->context, p->entries);
    stp_free(p->context, p->frames);
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
        stp_parallel_for(context, surfels->count, 16384, make_frames, &p);
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
