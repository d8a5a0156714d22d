// SPDX-License-Identifier: MIT
//
// The colour pyramid and coverage, from the finest octave to the coarsest.
//
// Finest: each candidate is assigned to the nearest surfel on its side; a surfel's colour is the
// average of its candidates. Coarser: each surfel of an octave's prefix is assigned to the nearest
// of the next coarser prefix. Surfels of a prefix are evenly spaced, so each has the same area,
// times the share of its disk that is surface: that is the weight. All sums are integers, so they
// do not depend on the order of threads.
#include "lod/blue/pyramid.h"

#include "base/math/color.h"

#include <assert.h>
#include <string.h>

#define LINEAR_ONE 1048576.0f // linear light as integers: 1 is 2^20
#define GRAIN 16384
#define AHEAD 24u // samples to prefetch ahead

// Contribution to a surfel's sum.
typedef struct sample {
    uint32_t color[3];
    uint64_t weight, alpha, area;
    float toward[3]; ///< its area times its normal
} sample;

static void add_sample(stp_pyramid_sum* sum, const sample* s)
{
    for (int k = 0; k < 3; ++k) {
        sum->color[k] += s->weight * s->color[k];
        sum->toward[k] += (int64_t)s->toward[k];
    }
    sum->weight += s->weight;
    sum->alpha += s->area * s->alpha;
    sum->area += s->area;
}

static sample candidate_sample(const stp_pyramid* p, uint32_t candidate)
{
    const uint8_t* c = p->input->finish->candidates->colors + 4 * (size_t)candidate;
    return (sample){
        .color = {p->linear[c[0]], p->linear[c[1]], p->linear[c[2]]},
        .weight = c[3] > 0 ? c[3] : 1, // nearly transparent samples have little weight
        .alpha = c[3],
        .area = stp_candidate_area(&p->areas, candidate, c[3]),
    };
}

static void add_candidates(stp_pyramid* p, const stp_grid* samples)
{
    const uint8_t* colors = p->input->finish->candidates->colors;
    for (uint32_t at = 0; at < samples->count; ++at) {
        if (at + AHEAD < samples->count) {
            __builtin_prefetch(colors + 4 * (size_t)samples->index[at + AHEAD]);
            __builtin_prefetch(&p->sums[p->nearest[at + AHEAD] & INT32_MAX]);
        }
        if (p->nearest[at] != UINT32_MAX) {
            assert(p->nearest[at] < p->surfels->count);
            sample s = candidate_sample(p, samples->index[at]);
            s.toward[0] = (float)s.area * samples->nx[at];
            s.toward[1] = (float)s.area * samples->ny[at];
            s.toward[2] = (float)s.area * samples->nz[at];
            add_sample(&p->sums[p->nearest[at]], &s);
        }
    }
}

static void add_surfels(stp_pyramid* p, const stp_grid* samples, const stp_pyramid_entry* finer)
{
    for (uint32_t at = 0; at < samples->count; ++at) {
        if (at + AHEAD < samples->count) {
            const stp_pyramid_entry* next = &finer[samples->index[at + AHEAD]];
            __builtin_prefetch(next);
            __builtin_prefetch(&next->toward[2]); // may be on the next cache line
            __builtin_prefetch(&p->sums[p->nearest[at + AHEAD] & INT32_MAX]);
        }
        assert(p->nearest[at] == UINT32_MAX || p->nearest[at] < samples->count);
        const stp_pyramid_entry* e = &finer[samples->index[at]];
        if (p->nearest[at] != UINT32_MAX) {
            sample s = {.color = {e->color[0], e->color[1], e->color[2]},
                        .weight = e->fraction > 0 ? e->fraction : 1,
                        .alpha = e->alpha,
                        .area = (uint64_t)e->area,
                        .toward = {e->toward[0], e->toward[1], e->toward[2]}};
            add_sample(&p->sums[p->nearest[at]], &s);
        }
    }
}

// Entry of a surfel without assigned samples: its finer entry, or that of its own candidate.
static stp_pyramid_entry single_entry(const stp_pyramid* p, const stp_pyramid_entry* finer,
                                      uint32_t surfel)
{
    if (finer != NULL) {
        return finer[surfel];
    }
    sample s = candidate_sample(p, p->input->finish->order[surfel]);
    const float* n = p->input->normals + 3 * (size_t)surfel;
    float area = (float)s.area;
    return (stp_pyramid_entry){.color = {s.color[0], s.color[1], s.color[2]},
                               .alpha = stp_pyramid_fraction((double)s.alpha / 255.0),
                               .area = area,
                               .toward = {area * n[0], area * n[1], area * n[2]}};
}

// Averages the contributions. `alpha_one`: alpha value of an opaque sample.
static void average_octave(stp_pyramid* p, uint32_t octave, const stp_pyramid_entry* finer,
                           uint32_t alpha_one)
{
    uint32_t count = p->surfels->octave_ends[octave];
    for (uint32_t i = 0; i < count; ++i) {
        const stp_pyramid_sum* sum = &p->sums[i];
        stp_pyramid_entry* e = &p->octaves[octave][i];
        if (sum->weight == 0) {
            *e = single_entry(p, finer, i);
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            e->color[k] = (uint32_t)((sum->color[k] + sum->weight / 2) / sum->weight);
            e->toward[k] = (float)sum->toward[k];
        }
        double one = (double)sum->area * alpha_one;
        assert(one > 0.0 && (double)sum->alpha <= one * (1.0 + 1e-9));
        e->alpha = stp_pyramid_fraction((double)sum->alpha / one);
        e->area = (float)sum->area;
    }
}

static void find_nearest(stp_pyramid* p, const stp_octave_plan* plan, const stp_grid* surfels,
                         const stp_grid* samples)
{
    stp_nearest_search search = {.surfels = surfels,
                                 .samples = samples,
                                 .radius = plan->radius * 1.0001f,
                                 .two_sided = p->input->finish->two_sided,
                                 .nearest = p->nearest};
    stp_nearest_search_run(p->context, &search);
}

// Normals for the grids; none if their sign is ignored.
static const float* normals_of(const stp_pyramid* p, const float* normals)
{
    return p->input->finish->two_sided ? NULL : normals;
}

typedef struct copying {
    stp_pyramid* p;
    stp_pyramid_entry* entries;
} copying;

static void copy_candidates(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const copying* c = user;
    for (size_t i = begin; i < end; ++i) {
        if (i + AHEAD < end) {
            __builtin_prefetch(c->p->input->finish->candidates->colors +
                               4 * (size_t)c->p->input->finish->order[i + AHEAD]);
        }
        c->entries[i] = single_entry(c->p, NULL, (uint32_t)i);
    }
}

// The finest octave where every candidate was chosen: each surfel has its own colour.
static stp_result copy_finest(stp_pyramid* p, uint32_t octave, stp_octave_plan* plan)
{
    copying c = {p, p->octaves[octave]};
    stp_parallel_for(p->context, p->surfels->count, GRAIN, copy_candidates, &c);
    stp_pyramid_keep_lights(p, octave);
    const stp_candidates* points = p->input->finish->candidates;
    stp_result result =
        stp_grid_create_uncrowded(p->context, points->positions, normals_of(p, points->normals),
                                  points->count, plan->cell, &p->candidates);
    plan->cell = p->candidates.cell;
    return result;
}

// The finest octave: colours of candidates.
static stp_result make_finest(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan,
                              const stp_grid* surfels)
{
    const stp_candidates* c = p->input->finish->candidates;
    stp_result result = stp_grid_create(p->context, c->positions, normals_of(p, c->normals),
                                        c->count, plan->cell, 0.5f * plan->cell, &p->candidates);
    if (result == STP_OK) {
        find_nearest(p, plan, surfels, &p->candidates);
        add_candidates(p, &p->candidates);
        average_octave(p, octave, NULL, 255);
        stp_pyramid_sum_lights(p, octave, &p->candidates);
    }
    return result;
}

// The others: colours of the next finer octave.
static stp_result make_coarser(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan,
                               const stp_grid* surfels)
{
    stp_grid samples;
    stp_result result = stp_grid_create(
        p->context, p->input->positions, normals_of(p, p->input->normals),
        p->surfels->octave_ends[octave + 1], plan->cell, 0.5f * plan->cell, &samples);
    if (result != STP_OK) {
        return result;
    }
    find_nearest(p, plan, surfels, &samples);
    add_surfels(p, &samples, p->octaves[octave + 1]);
    average_octave(p, octave, p->octaves[octave + 1], 65535);
    stp_pyramid_sum_lights(p, octave, &samples);
    stp_grid_destroy(p->context, &samples);
    return STP_OK;
}

// Computes the colours of an octave.
static stp_result color_octave(stp_pyramid* p, uint32_t octave, stp_octave_plan* plan)
{
    bool finest = octave + 1 == p->surfels->octave_count;
    if (finest && stp_pyramid_keeps_candidates(p)) {
        return copy_finest(p, octave, plan);
    }
    uint32_t count = p->surfels->octave_ends[octave];
    memset(p->sums, 0, count * sizeof(*p->sums));
    stp_grid surfels;
    stp_result result =
        stp_grid_create_uncrowded(p->context, p->input->positions, normals_of(p, p->input->normals),
                                  count, plan->cell, &surfels);
    if (result != STP_OK) {
        return result;
    }
    plan->cell = surfels.cell;
    plan->radius = stp_min(plan->radius, plan->cell * 0.4995f);
    assert(!(2.0f * plan->radius > plan->cell) && "2 x 2 x 2 cells hold all within the radius");
    result =
        finest ? make_finest(p, octave, plan, &surfels) : make_coarser(p, octave, plan, &surfels);
    stp_grid_destroy(p->context, &surfels);
    return result;
}

static stp_result make_octave(stp_pyramid* p, uint32_t octave)
{
    stp_octave_plan plan;
    stp_pyramid_plan_octave(p, octave, &plan);
    stp_result result = color_octave(p, octave, &plan);
    if (result == STP_OK) {
        result = stp_pyramid_cover(p, octave, &plan);
    }
    if (result == STP_OK) {
        result = stp_pyramid_choose_chances(p, octave, &plan);
    }
    return result == STP_OK ? stp_pyramid_close_holes(p, octave, &plan) : result;
}

static void write_entries(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const stp_pyramid* p = user;
    for (size_t at = begin; at < end; ++at) { // octaves are consecutive in both arrays
        const stp_pyramid_entry* e = &p->entries[at];
        for (int k = 0; k < 3; ++k) {
            p->surfels->colors[3 * at + (size_t)k] =
                stp_linear_to_srgb8((float)e->color[k] / LINEAR_ONE);
        }
        p->surfels->coverages[at] = e->coverage;
    }
}

// The same for a finest octave that keeps the candidates' colours: gives the same result without
// conversions.
static void write_kept(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const stp_pyramid* p = user;
    const uint8_t* colors = p->input->finish->candidates->colors;
    const uint32_t* order = p->input->finish->order;
    assert(p->entry_count >= p->surfels->count && "the finest octave comes last");
    size_t first = p->entry_count - p->surfels->count;
    for (size_t i = begin; i < end; ++i) {
        if (i + AHEAD < end) {
            __builtin_prefetch(colors + 4 * (size_t)order[i + AHEAD]);
        }
        memcpy(p->surfels->colors + 3 * (first + i), colors + 4 * (size_t)order[i], 3);
        p->surfels->coverages[first + i] = p->entries[first + i].coverage;
    }
}

static void write_colors(stp_pyramid* p)
{
    size_t kept = stp_pyramid_keeps_candidates(p) ? p->surfels->count : 0;
    stp_parallel_for(p->context, p->entry_count - kept, GRAIN, write_entries, p);
    stp_parallel_for(p->context, kept, GRAIN, write_kept, p);
}

static stp_result allocate_pyramid(stp_pyramid* p)
{
    const stp_splats* s = p->surfels;
    size_t total = 0, count = s->count, samples = p->input->finish->candidates->count;
    // octaves that are summed up
    size_t sums = !stp_pyramid_keeps_candidates(p) ? count
                  : s->octave_count > 1            ? s->octave_ends[s->octave_count - 2]
                                                   : 1;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        total += s->octave_ends[i];
    }
    p->entry_count = total;
    p->entries = STP_NEW_ARRAY(p->context, stp_pyramid_entry, total);
    p->fraction_column = STP_NEW_ARRAY(p->context, uint16_t, total);
    p->sums = STP_NEW_ARRAY(p->context, stp_pyramid_sum, sums);
    p->nearest = STP_NEW_ARRAY(p->context, uint32_t, samples > count ? samples : count);
    if (p->entries == NULL || p->fraction_column == NULL || p->sums == NULL || p->nearest == NULL) {
        return stp_fail_memory(p->context);
    }
    stp_result result = stp_pyramid_allocate_lights(p, total, sums);
    total = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        p->octaves[i] = p->entries + total;
        p->fractions[i] = p->fraction_column + total;
        total += s->octave_ends[i];
    }
    assert(total == p->entry_count);
    return result;
}

static void free_pyramid(stp_pyramid* p)
{
    stp_grid_destroy(p->context, &p->candidates);
    stp_free(p->context, p->visit);
    stp_free(p->context, p->disks);
    stp_free(p->context, p->nearest);
    stp_free(p->context, p->light_sums);
    stp_free(p->context, p->lights);
    stp_free(p->context, p->sums);
    stp_free(p->context, p->fraction_column);
    stp_free(p->context, p->entries);
}

stp_result stp_make_pyramid(stp_context* context, const stp_pyramid_input* input,
                            stp_splats* surfels)
{
    assert(surfels->octave_count > 0 && surfels->octave_count <= STP_OCTAVE_LIMIT);
    assert(surfels->octave_ends[surfels->octave_count - 1] == surfels->count);
    stp_pyramid p = {
        .context = context, .input = input, .surfels = surfels, .stencil = stp_stencil_make()};
    p.areas = stp_candidate_areas_make(input->finish->candidates);
    stp_clip_table_make(&p.stencil, &p.clips);
    for (int i = 0; i < 256; ++i) {
        p.linear[i] = (uint32_t)(stp_srgb8_to_linear((uint8_t)i) * LINEAR_ONE + 0.5f);
    }
    stp_result result = allocate_pyramid(&p);
    for (uint32_t octave = surfels->octave_count; result == STP_OK && octave > 0; --octave) {
        uint32_t done = surfels->octave_count - octave;
        result = stp_progress(context, "finish", (double)done / (double)surfels->octave_count);
        if (result == STP_OK) {
            result = make_octave(&p, octave - 1);
        }
    }
    if (result == STP_OK) {
        write_colors(&p);
        result = stp_pyramid_write_lights(&p);
    }
    free_pyramid(&p);
    return result;
}
