// SPDX-License-Identifier: MIT
//
// Share of a surfel's disk that is surface, per octave. The disks are sampled by the candidates of
// the capture, by every k-th of them if disks are large, or by a longer prefix of the surfels if
// one is dense enough.
#include "lod/blue/pyramid.h"

#include <assert.h>

// Surfels that sample a disk have a coverage radius of an eighth of its radius: then each cell of
// the stencil, a quarter wide, that is full of surface contains at least one.
#define SAMPLE_RADIUS 0.125f
// If candidates sample, each represents up to one in this many of a disk's pixels.
#define DISK_CANDIDATES 32.0
// Half the side of a square, relative to the radius of a disk of equal area.
#define DISK_SQUARE 0.88622693f
// The opacity of a splat of a set is its share of surface. The number of these splats is not
// meaningful, and is made so large that it never counts.
#define SET_WEIGHT 1024u
// Cells that a disk extends to each side; only orders with huge gaps would need more.
#define MAX_CELLS 12.0f
// Share of a seen fraction that is trusted regardless of counts.
#define MIN_BELIEVED 0.4

static float pixel_size(const stp_pyramid* p)
{
    return (float)p->input->finish->candidates->pixel_size;
}

// The area of a disk in pixels of the capture.
static double disk_pixels(const stp_pyramid* p, float radius)
{
    double pixels = pixel_size(p) > 0.0f ? (double)(radius / pixel_size(p)) : 1.0;
    return STP_PI * pixels * pixels;
}

// Factor on the squares of every stride-th candidate. A thinned grid takes equally many from each
// region: its gaps are more uniform, and slightly smaller squares close them.
static float widen(uint32_t stride)
{
    return stride > 1 ? sqrtf((float)stride * 0.75f) : 1.0f;
}

// Half the side of the square that a captured candidate represents. A pixel is up to 1.7 times as
// wide along a slope as across: squares of twice its width leave no gaps.
static float pixel_footprint(const stp_pyramid* p, const stp_octave_plan* plan)
{
    return stp_min(pixel_size(p) * widen(plan->stride), plan->disk_radius);
}

// The same for a splat of a set: the square has the area of its disk.
static float set_footprint(const stp_pyramid* p, const stp_octave_plan* plan)
{
    float side = p->input->finish->candidates->set_radius * DISK_SQUARE;
    return stp_min(side * widen(plan->stride), plan->disk_radius);
}

static float candidate_footprint(const stp_pyramid* p, const stp_octave_plan* plan)
{
    const stp_candidates* c = p->input->finish->candidates;
    float largest = c->set_count < c->count ? pixel_footprint(p, plan) : 0.0f;
    return c->set_count != 0 ? stp_max(largest, set_footprint(p, plan)) : largest;
}

// Shortest prefix that is dense enough to sample the disks of an octave; 0: none, so candidates are
// used.
static uint32_t sample_count(const stp_pyramid* p, float radius)
{
    const float* envelope = p->input->envelope;
    // searches the first index at which the envelope is small enough
    uint32_t low = 1, high = p->surfels->count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (envelope[middle] <= radius * SAMPLE_RADIUS) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    assert((low == p->surfels->count || envelope[low] <= radius * SAMPLE_RADIUS) && low > 0);
    bool all = low == p->surfels->count;
    return all && p->input->finish->final_radius > radius * SAMPLE_RADIUS ? 0 : low;
}

void stp_pyramid_plan_octave(const stp_pyramid* p, uint32_t octave, stp_octave_plan* plan)
{
    const stp_splats* s = p->surfels;
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
    plan->cell = stp_max(2.002f * plan->radius, wide);
    assert(plan->disk_radius > 0.0f && plan->stride > 0 && plan->dense_count <= s->count);
}

static void set_fraction(stp_pyramid* p, uint32_t octave, uint32_t surfel, double fraction)
{
    p->octaves[octave][surfel].fraction = stp_pyramid_fraction(fraction);
    p->fractions[octave][surfel] = p->octaves[octave][surfel].fraction;
}

static double opacity(const stp_pyramid_entry* e)
{
    return (double)e->alpha / 65535.0;
}

// Candidates per square pixel of surface, from all views that face it.
static double typical_density(const stp_candidates* candidates)
{
    return candidates->direction_count != 0 ? 0.25 * candidates->direction_count : 1.0;
}

// Octaves sampled by every stride-th candidate. Their squares widen thin geometry, and their number
// is more accurate; but geometry may be hidden from some views, so the number alone is not trusted
// either.
static void cover_captured(stp_pyramid* p, uint32_t octave, double pixels, uint32_t stride)
{
    double full_count = typical_density(p->input->finish->candidates) * pixels / stride;
    double believed = MIN_BELIEVED / sqrt((double)stride);
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

// Octaves sampled by surfels: hits are weighted by their mean fraction.
static void cover_sampled(stp_pyramid* p, uint32_t octave)
{
    for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
        const stp_disk* disk = &p->disks[i];
        double fraction = (double)stp_stencil_fraction(&p->stencil, disk->cells);
        fraction *=
            disk->count != 0 ? (double)disk->fractions / ((double)disk->count * 65535.0) : 1.0;
        set_fraction(p, octave, i, fraction);
    }
}

// Lists the surfels of a prefix along the curve, from those of a longer one.
static void list_prefix(stp_pyramid* p, uint32_t count)
{
    uint32_t listed = 0;
    for (uint32_t i = 0; i < p->visit_count; ++i) {
        uint32_t surfel = p->visit[i];
        p->visit[listed] = surfel;
        listed += surfel < count;
    }
    assert(listed == count && "a longer list holds each surfel once");
    p->visit_count = listed;
}

static stp_disk_search begin_disk_search(stp_pyramid* p, uint32_t octave,
                                         const stp_octave_plan* plan, const stp_grid* samples)
{
    assert(p->visit_count == p->surfels->octave_ends[octave]);
    return (stp_disk_search){
        .samples = samples,
        .positions = p->input->positions,
        .normals = p->input->normals,
        .visit = p->visit,
        .count = p->surfels->octave_ends[octave],
        .radius = stp_min(plan->disk_radius, MAX_CELLS * samples->cell),
        .two_sided = p->input->finish->two_sided,
        .stencil = &p->stencil,
        .disks = p->disks,
    };
}

static void cover_by_surfels(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan,
                             const stp_grid* samples)
{
    stp_disk_search search = begin_disk_search(p, octave, plan, samples);
    uint32_t finer = octave + 1;
    while (p->surfels->octave_ends[finer] < plan->dense_count) {
        finer += 1;
        assert(finer < p->surfels->octave_count);
    }
    search.fractions = p->fractions[finer];
    stp_disk_search_run(p->context, &search);
    cover_sampled(p, octave);
}

static void cover_by_candidates(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan,
                                const stp_grid* samples)
{
    stp_disk_search search = begin_disk_search(p, octave, plan, samples);
    const stp_candidates* c = p->input->finish->candidates;
    search.footprint = candidate_footprint(p, plan);
    search.sample_count = c->count;
    search.set_count = c->set_count;
    search.set_footprint = set_footprint(p, plan);
    search.set_weight = SET_WEIGHT;
    search.until_full = true;
    stp_disk_search_run(p->context, &search);
    cover_captured(p, octave, disk_pixels(p, search.radius), plan->stride);
}

static stp_result cover_by_thinned_candidates(stp_pyramid* p, uint32_t octave,
                                              const stp_octave_plan* plan)
{
    float cell = plan->disk_radius + candidate_footprint(p, plan);
    if (plan->stride == 1 && cell <= MAX_CELLS * p->candidates.cell) {
        cover_by_candidates(p, octave, plan, &p->candidates);
        return STP_OK;
    }
    stp_grid samples;
    stp_result result = stp_grid_thin(p->context, &p->candidates, plan->stride, cell, &samples);
    if (result == STP_OK) {
        cover_by_candidates(p, octave, plan, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

static stp_result cover_by_dense_surfels(stp_pyramid* p, uint32_t octave,
                                         const stp_octave_plan* plan)
{
    stp_grid samples;
    const float* normals = p->input->finish->two_sided ? NULL : p->input->normals;
    stp_result result = stp_grid_create(p->context, p->input->positions, normals, plan->dense_count,
                                        plan->cell, 0.0f, &samples);
    if (result == STP_OK) {
        cover_by_surfels(p, octave, plan, &samples);
        stp_grid_destroy(p->context, &samples);
    }
    return result;
}

// Lists the octave's surfels along the curve. A finer list, if any, contains them.
static stp_result list_surfels(stp_pyramid* p, uint32_t count)
{
    if (p->visit_count != 0) {
        list_prefix(p, count);
        return STP_OK;
    }
    p->disks = STP_NEW_ARRAY(p->context, stp_disk, count);
    p->visit = STP_NEW_ARRAY(p->context, uint32_t, count);
    if (p->disks == NULL || p->visit == NULL) {
        return stp_fail_memory(p->context);
    }
    p->visit_count = count;
    return stp_sort_spatially(p->context, p->input->positions, count, p->visit);
}

static void cover_wholly(stp_pyramid* p, uint32_t octave)
{
    for (uint32_t i = 0; i < p->surfels->octave_ends[octave]; ++i) {
        set_fraction(p, octave, i, opacity(&p->octaves[octave][i]));
    }
}

stp_result stp_pyramid_cover(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    if (stp_pyramid_is_whole(p, plan)) {
        cover_wholly(p, octave);
        return STP_OK;
    }
    stp_result result = list_surfels(p, p->surfels->octave_ends[octave]);
    if (result != STP_OK) {
        return result;
    }
    assert(p->candidates.index != NULL && "the finest octave has made the grid");
    if (octave + 1 == p->surfels->octave_count) {
        cover_by_candidates(p, octave, plan, &p->candidates);
        return STP_OK;
    }
    return plan->dense_count != 0 ? cover_by_dense_surfels(p, octave, plan)
                                  : cover_by_thinned_candidates(p, octave, plan);
}
