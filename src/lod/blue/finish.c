// SPDX-License-Identifier: MIT
#include "lod/blue/finish.h"

#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "lod/blue/blue.h"
#include "lod/set_columns.h"

#include <assert.h>
#include <string.h>

#define PAPER_COUNT 1000u // p_m, as in Brandt 4.1
#define GRAIN 16384
#define AHEAD 24u        // candidates to prefetch ahead
#define OVERLAP_MAX 64.0 // maximum number of disks of an octave over each place, on average

typedef struct finish {
    const stp_finish_input* input;
    stp_splats* surfels;
    float* positions; ///< 3 per surfel, relative to the candidates' origin
    float* normals;
    float* envelope;  ///< coverage radius of the first i surfels
    uint8_t* growths; ///< growth of each surfel; NULL: plain
} finish;

static void gather_surfels(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    finish* f = user;
    const stp_candidates* candidates = f->input->candidates;
    for (size_t i = begin; i < end; ++i) {
        if (i + AHEAD < end) {
            size_t next = 3 * (size_t)f->input->order[i + AHEAD];
            __builtin_prefetch(candidates->positions + next);
            __builtin_prefetch(candidates->normals + next);
        }
        assert(f->input->order[i] < candidates->count);
        size_t from = 3 * (size_t)f->input->order[i];
        memcpy(f->positions + 3 * i, candidates->positions + from, 3 * sizeof(float));
        memcpy(f->normals + 3 * i, candidates->normals + from, 3 * sizeof(float));
    }
}

// The step is a power of two, so its reciprocal is exact.
static uint16_t quantise(double position, double origin, double per_step)
{
    double value = (position - origin) * per_step + 0.5;
    assert(!(value < 0.0) && !(value >= 65536.0) && "the grid spans all positions");
    return (uint16_t)(value < 0.0 ? 0.0 : value > 65535.0 ? 65535.0 : value);
}

static uint8_t shading_of(const finish* f, size_t surfel)
{
    const stp_finish_input* input = f->input;
    uint32_t candidate = input->order[surfel], material = input->candidates->materials[candidate];
    bool of_set = candidate >= stp_first_of_sets(input->candidates);
    uint8_t shading = of_set ? (uint8_t)material : input->shading_of_material[material];
    if (of_set && input->growths != NULL) {
        shading = input->growths->plain[shading];
    }
    return f->growths != NULL ? input->growths->of[shading][f->growths[surfel]] : shading;
}

static void write_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    finish* f = user;
    stp_splats* s = f->surfels;
    stp_vec3d centre = f->input->candidates->origin;
    double per_step = 1.0 / (double)s->step;
    stp_octahedral_encode_many(f->normals + 3 * begin, end - begin, s->normals + 2 * begin);
    for (size_t i = begin; i < end; ++i) {
        if (i + AHEAD < end) {
            __builtin_prefetch(f->input->candidates->materials + f->input->order[i + AHEAD]);
        }
        const float* p = f->positions + 3 * i;
        s->positions[3 * i] = quantise(centre.x + (double)p[0], (double)s->origin.x, per_step);
        s->positions[3 * i + 1] = quantise(centre.y + (double)p[1], (double)s->origin.y, per_step);
        s->positions[3 * i + 2] = quantise(centre.z + (double)p[2], (double)s->origin.z, per_step);
        s->materials[i] = shading_of(f, i);
    }
}

static void choose_grid(finish* f)
{
    stp_box box = stp_box_of(f->positions, f->input->count);
    stp_vec3d centre = f->input->candidates->origin;
    stp_boxd placed = {stp_addd(centre, stp_to_double(box.min)),
                       stp_addd(centre, stp_to_double(box.max))};
    // a step far below the capture's pixel would only waste bits; it also gives a single point a
    // grid
    double min_step = f->input->candidates->pixel_size * 0x1p-10;
    stp_choose_position_grid(placed, min_step, &f->surfels->origin, &f->surfels->step);
}

// Coverage radius of each prefix: the maximum distance of all later and all unchosen candidates.
static void make_envelope(finish* f)
{
    float maximum = f->input->final_radius;
    for (uint32_t i = f->input->count; i > 0; --i) {
        assert(!(f->input->radii[i - 1] < 0.0f));
        maximum = stp_max(maximum, f->input->radii[i - 1]);
        f->envelope[i - 1] = maximum;
    }
}

static stp_result allocate_columns(stp_context* context, stp_splats* s)
{
    size_t entries = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        entries += s->octave_ends[i];
    }
    assert(s->octave_count > 0 && s->octave_ends[s->octave_count - 1] == s->count);
    s->positions = STP_NEW_ARRAY(context, uint16_t, 3 * (size_t)s->count);
    s->normals = STP_NEW_ARRAY(context, int8_t, 2 * (size_t)s->count);
    s->materials = STP_NEW_ARRAY(context, uint8_t, s->count);
    s->colors = STP_NEW_ARRAY(context, uint8_t, 3 * entries);
    s->coverages = STP_NEW_ARRAY(context, uint8_t, entries);
    bool made = s->positions != NULL && s->normals != NULL && s->materials != NULL &&
                s->colors != NULL && s->coverages != NULL;
    return made ? STP_OK : stp_fail_memory(context);
}

typedef struct value_column {
    stp_attribute attribute;
    const uint32_t* order;
    const void* from;
    unsigned char* to;
} value_column;

static void gather_values(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const value_column* c = user;
    stp_copy_attribute(c->attribute, c->from, c->order + begin, end - begin,
                       c->to + begin * stp_attribute_size(c->attribute), NULL);
}

// Surfels of a cloud are points, and have their attributes.
static stp_result take_attributes(stp_context* context, const stp_finish_input* input,
                                  stp_splats* s)
{
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        if (input->candidates->attributes[a] == NULL) {
            continue;
        }
        value_column c = {.attribute = (stp_attribute)a,
                          .order = input->order,
                          .from = input->candidates->attributes[a]};
        c.to = stp_alloc_array(context, s->count, stp_attribute_size(c.attribute));
        if (c.to == NULL) {
            return stp_fail_memory(context);
        }
        s->attributes[a] = c.to;
        stp_parallel_for(context, s->count, GRAIN, gather_values, &c);
    }
    return STP_OK;
}

static void make_tables(finish* f)
{
    stp_splats* s = f->surfels;
    stp_prefix_table_make(&s->table, f->input->radii, s->count, f->input->final_radius);
    // the table's guarantee holds for the rounded positions: they lie within half a step on each
    // axis. Adding a constant keeps interpolation conservative: log(r + c) is convex where log r is
    // linear.
    assert(s->table.size > 0 && s->table.count[s->table.size - 1] == s->count);
    float rounding = s->step * 0.8660255f;
    for (uint32_t i = 0; i < s->table.size; ++i) {
        s->table.radius[i] = (s->table.radius[i] + rounding) * (1.0f + 0x1p-22f);
    }
    s->paper_count = s->count < PAPER_COUNT ? s->count : PAPER_COUNT;
    s->paper_radius =
        stp_median_spacing(f->positions, f->input->by_side ? f->normals : NULL, s->paper_count);
}

// Disks of an even order overlap about seven times. Only clouds are limited: a capture's pixels do
// not tell its area.
static double area_limit(const finish* f)
{
    const stp_candidates* c = f->input->candidates;
    bool known = c->direction_count == 0 && c->pixel_size > 0.0;
    return known ? OVERLAP_MAX * (double)c->count * c->pixel_size * c->pixel_size : HUGE_VAL;
}

// Points keep the distance to which the surface around each of them reaches. Where all points are
// surfels, it may be less than the set's candidate radius; where surfels stand for other points, it
// only adds to that.
static stp_result find_growths(stp_context* context, finish* f)
{
    const stp_finish_input* input = f->input;
    if (input->growths == NULL || !(input->spacing > 0.0f) || f->surfels->count < 2) {
        return STP_OK;
    }
    f->growths = STP_NEW_ARRAY(context, uint8_t, input->count);
    if (f->growths == NULL) {
        return stp_fail_memory(context);
    }
    stp_growth_desc desc = {.positions = f->positions,
                            .normals = f->normals,
                            .count = input->count,
                            .sparse_count = input->count,
                            .spacing = stp_max(input->spacing, input->final_radius),
                            .covered = input->final_radius,
                            .radius = f->surfels->candidate_radius,
                            .smaller = !(input->final_radius > 0.0f)};
    while (input->exact && desc.sparse_count > 1 &&
           input->radii[desc.sparse_count - 1] < desc.spacing) {
        desc.sparse_count -= 1;
    }
    return stp_growths_find(context, &desc, f->growths);
}

static stp_result finish_surfels(stp_context* context, finish* f)
{
    stp_splats* s = f->surfels;
    size_t count = f->input->count;
    f->positions = STP_NEW_ARRAY(context, float, 3 * count);
    f->normals = STP_NEW_ARRAY(context, float, 3 * count);
    f->envelope = STP_NEW_ARRAY(context, float, count);
    if (f->positions == NULL || f->normals == NULL || f->envelope == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, count, GRAIN, gather_surfels, f);
    make_envelope(f);
    choose_grid(f);
    s->count = f->input->count;
    double radius = f->input->candidates->surface_radius;
    radius = radius > 0.0 ? radius : f->input->candidates->pixel_size * 0.70710678118654752;
    s->candidate_radius = (float)radius;
    s->octave_count = stp_choose_octaves(f->envelope, s->candidate_radius, area_limit(f), s->count,
                                         s->octave_ends);
    stp_result result = allocate_columns(context, s);
    result = result == STP_OK ? take_attributes(context, f->input, s) : result;
    result = result == STP_OK ? find_growths(context, f) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_parallel_for(context, count, GRAIN, write_columns, f);
    make_tables(f);
    stp_pyramid_input pyramid = {.finish = f->input,
                                 .positions = f->positions,
                                 .normals = f->normals,
                                 .envelope = f->envelope,
                                 .candidate_radius = s->candidate_radius};
    return stp_make_pyramid(context, &pyramid, s);
}

stp_result stp_finish_surfels(stp_context* context, const stp_finish_input* input,
                              stp_splats* surfels)
{
    assert(input->count > 0 && input->count <= input->candidates->count);
    assert(!(input->final_radius < 0.0f));
    *surfels = (stp_splats){0};
    finish f = {.input = input, .surfels = surfels};
    stp_result result = finish_surfels(context, &f);
    stp_free(context, f.growths);
    stp_free(context, f.envelope);
    stp_free(context, f.normals);
    stp_free(context, f.positions);
    if (result != STP_OK) {
        stp_splats_destroy(context, surfels);
    }
    return result;
}
