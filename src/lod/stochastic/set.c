// SPDX-License-Identifier: MIT
#include "lod/stochastic/set.h"

#include "base/math/rng.h"
#include "base/splats/coverage.h"
#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "base/splats/octahedral.h"
#include "lod/blue/finish.h"
#include "lod/cloud_candidates.h"
#include "lod/samples.h"
#include "lod/set_columns.h"
#include "lod/stochastic/leaf_passes.h"
#include "lod/stochastic/leaf_properties.h"

#include <assert.h>
#include <string.h>

enum {
    GRAIN = 16384, ///< points
    LEAF_GRAIN = 32,
    BATCH = 64,       ///< splats whose normals are encoded together
    OCTAVES_MAX = 16, ///< more octaves than 2^32 points have
};
#define SEED UINT64_C(0x42686B72)
#define LARGEST 2.0f // maximum spacing of isolated points, relative to the median spacing
/// Radius of a splat, in sides of the square that it represents (STP_CUE_COVERING)
#define GROWTH 1.05f
#define DISK_RATIO 0.8f          // ratio of radii from which a splat is a disk
#define FINEST 0x1p-10           // minimum grid step, in spacings; finer steps would waste bits
#define HALF_DIAGONAL 0.8660255f // half the diagonal of a unit cube
/// Spacings of leaves are clamped to this factor above and below the median spacing
#define OUTLIER 8.0f

typedef struct set_maker {
    stp_context* context;
    const stp_stochastic_source* source;
    const stp_leaf_desc* desc;
    stp_candidates* candidates;
    stp_splats* splats;
    uint16_t* places; ///< candidates' positions on the grid
    stp_leaf_octree octree;
    stp_leaf_properties* properties;
    float spacing; ///< median spacing, in steps
    stp_shape_directions directions;
} set_maker;

/// Copies those attributes of candidates that exist.
static void copy_attributes(const set_maker* m, const uint32_t* from, const uint32_t* to,
                            uint32_t count)
{
    for (int a = 0; a < STP_ATTRIBUTES; ++a) {
        if (m->candidates->attributes[a] != NULL) {
            stp_copy_attribute((stp_attribute)a, m->candidates->attributes[a], from, count,
                               m->splats->attributes[a], to);
        }
    }
}

static stp_result allocate_attributes(const set_maker* m)
{
    for (int a = 0; a < STP_ATTRIBUTES; ++a) {
        if (m->candidates->attributes[a] == NULL) {
            continue;
        }
        m->splats->attributes[a] =
            stp_alloc_array(m->context, m->splats->count, stp_attribute_size((stp_attribute)a));
        if (m->splats->attributes[a] == NULL) {
            return stp_fail_memory(m->context);
        }
    }
    return STP_OK;
}

static void choose_grid(set_maker* m)
{
    const stp_candidates* c = m->candidates;
    stp_box box = stp_box_of(c->positions, c->count);
    stp_vec3 size = stp_sub(box.max, box.min);
    double diagonal = (double)stp_length(size);
    double spacing = c->pixel_size > 0.0 ? c->pixel_size : diagonal / sqrt((double)c->count + 1.0);
    stp_boxd placed = {stp_addd(c->origin, stp_to_double(box.min)),
                       stp_addd(c->origin, stp_to_double(box.max))};
    stp_choose_position_grid(placed, spacing * FINEST, &m->splats->origin, &m->splats->step);
}

static void place_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    set_maker* m = user;
    const stp_candidates* c = m->candidates;
    const double origin[3] = {c->origin.x - (double)m->splats->origin.x,
                              c->origin.y - (double)m->splats->origin.y,
                              c->origin.z - (double)m->splats->origin.z};
    double per_step = 1.0 / (double)m->splats->step;
    for (size_t i = 3 * begin; i < 3 * end; ++i) {
        double place = (origin[i % 3] + (double)c->positions[i]) * per_step + 0.5;
        m->places[i] = (uint16_t)(place > 0.0 ? (place < 65535.0 ? place : 65535.0) : 0.0);
    }
}

/// Leaves with too few points get the median spacing; outliers are clamped to a factor of it.
static void settle_areas(set_maker* m)
{
    m->spacing = stp_leaf_median_spacing(&m->octree, m->properties);
    m->spacing = m->spacing > 0.0f ? m->spacing : 1.0f;
    for (uint32_t i = 0; i < m->octree.leaf_count; ++i) {
        stp_leaf_properties* f = &m->properties[i];
        uint32_t count = m->octree.leaves[i].end - m->octree.leaves[i].begin;
        float ratio = f->spacing > 0.0f ? f->spacing / m->spacing : 1.0f;
        float spacing = m->spacing * stp_clamp(ratio, 1.0f / OUTLIER, OUTLIER);
        f->area = spacing * spacing * (float)count;
    }
}

/// Recomputes the spacings of the remaining points, and clamps those of isolated ones.
static void settle_spacings(set_maker* m)
{
    for (uint32_t i = 0; i < m->octree.leaf_count; ++i) {
        uint32_t count = m->octree.leaves[i].end - m->octree.leaves[i].begin;
        m->properties[i].spacing = sqrtf(m->properties[i].area / (float)count);
    }
    m->spacing = stp_leaf_median_spacing(&m->octree, m->properties);
    for (uint32_t i = 0; i < m->octree.leaf_count; ++i) {
        m->properties[i].spacing = stp_min(m->properties[i].spacing, m->spacing * LARGEST);
    }
}

/// Orders the points of leaves, and keeps the first ones of each leaf.
static stp_result spread(set_maker* m)
{
    stp_context* context = m->context;
    uint32_t all = m->candidates->count, kept = m->splats->count;
    uint32_t* ranked = STP_NEW_ARRAY(context, uint32_t, all);
    if (ranked == NULL) {
        return stp_fail_memory(context);
    }
    stp_spread_order_make(context, m->places, &m->octree, ranked);
    if (kept < all) {
        stp_leaf_trim(&m->octree, m->properties, ranked, kept);
    }
    assert(m->octree.leaves[m->octree.leaf_count - 1].end == kept);
    stp_spread_order_place(context, ranked, kept, &m->octree);
    stp_free(context, ranked);
    return STP_OK;
}

/// Computes the planes of leaves and the features in them.
static stp_result find_features(set_maker* m, const stp_leaf_points* points)
{
    stp_context* context = m->context;
    stp_scatter* scatters = STP_NEW_ARRAY(context, stp_scatter, m->octree.leaf_count);
    if (scatters == NULL) {
        return stp_fail_memory(context);
    }
    stp_leaf_measure_planes(context, &m->octree, points, m->properties, scatters);
    stp_leaf_measure_scales(context, &m->octree, scatters, m->desc->scales, m->properties);
    stp_free(context, scatters);
    return STP_OK;
}

typedef struct leaf_normals {
    const set_maker* maker;
    uint8_t* missing; ///< by candidate: STP_NORMAL_*
} leaf_normals;

/// Gives points with too few neighbours the normals of their leaves, if these have a plane. Points
/// whose neighbours lie in a line keep the search: their plane is found farther away.
static void take_leaf_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const leaf_normals* l = user;
    const set_maker* m = l->maker;
    for (size_t i = begin; i < end; ++i) {
        const stp_leaf_cell* leaf = &m->octree.leaves[i];
        const stp_leaf_properties* f = &m->properties[i];
        for (uint32_t at = leaf->begin; at < leaf->end && f->known; ++at) {
            uint32_t point = m->octree.order[at];
            if (l->missing[point] == STP_NORMAL_NONE) {
                memcpy(m->candidates->normals + 3 * (size_t)point, &f->normal, sizeof(f->normal));
                l->missing[point] = STP_NORMAL_KNOWN;
            }
        }
    }
}

/// Estimates normals of points from their neighbours, or else those in their leaf, or else those
/// farther away.
static stp_result estimate_normals(set_maker* m)
{
    float around = sqrtf((float)m->desc->normal_neighbours / 3.14159265f); // in spacings
    float radius = around * m->spacing * m->splats->step;
    stp_normal_search search;
    stp_result result = stp_normal_search_start(m->context, m->candidates, radius, &search);
    if (result == STP_OK) {
        leaf_normals loop = {m, search.missing};
        stp_parallel_for(m->context, m->octree.leaf_count, LEAF_GRAIN, take_leaf_normals, &loop);
        result = stp_normal_search_finish(&search);
    }
    stp_normal_search_destroy(&search);
    return result;
}

/// Chooses the points of each leaf, and computes its properties.
static stp_result find_properties(set_maker* m)
{
    stp_context* context = m->context;
    bool oriented = m->source->has_normals;
    stp_leaf_points points = {m->places, m->candidates->normals, oriented};
    stp_result result = find_features(m, &points);
    if (result != STP_OK) {
        return result;
    }
    settle_areas(m);
    if (!oriented) {
        result = estimate_normals(m);
    }
    result = result == STP_OK ? spread(m) : result;
    if (result != STP_OK) {
        return result;
    }
    settle_spacings(m);
    if (oriented) {
        stp_leaf_measure_normals(context, &m->octree, &points, m->properties);
    } else {
        result = stp_orient_leaves(context, &m->octree, m->properties, m->desc->neighbours);
    }
    stp_leaf_measure_curvature(context, &m->octree, &points, m->properties);
    return result;
}

/// Splats of a leaf: ellipses with the area of its disks, whose directions depend on their normals.
typedef struct leaf_shape {
    const stp_leaf_properties* properties;
    uint32_t larger, smaller; ///< codes of the radii
} leaf_shape;

static leaf_shape shape_of_leaf(const stp_leaf_properties* f)
{
    float radius = stp_max(GROWTH * f->spacing, HALF_DIAGONAL);
    float ratio = f->ratio < DISK_RATIO ? sqrtf(f->ratio) : 1.0f;
    return (leaf_shape){.properties = f,
                        .larger = stp_shape_code(radius / ratio),
                        .smaller = stp_shape_code(radius * ratio)};
}

static void write_splat(const set_maker* m, const leaf_shape* shape, uint32_t from,
                        const int8_t normal[2], uint32_t at)
{
    stp_splats* s = m->splats;
    const stp_candidates* c = m->candidates;
    assert(from < c->count && at < s->count);
    uint32_t material = c->materials[from];
    bool of_set = from >= stp_first_of_sets(c);
    memcpy(s->positions + 3 * (size_t)at, m->places + 3 * (size_t)from, 3 * sizeof(uint16_t));
    memcpy(s->normals + 2 * (size_t)at, normal, 2);
    memcpy(s->colors + 3 * (size_t)at, c->colors + 4 * (size_t)from, 3);
    s->materials[at] = of_set ? (uint8_t)material : m->source->shading_of_material[material];
    uint8_t alpha = c->colors[4 * (size_t)from + 3];
    s->coverages[at] = m->source->coverages != NULL ? m->source->coverages[from]
                       : alpha < 255                ? stp_coverage_of_share((double)alpha / 255.0)
                                                    : (uint8_t)STP_COVERAGE_WHOLE;
    s->shapes[at] = stp_shape_of_codes(&m->directions, shape->larger, shape->smaller,
                                       shape->properties->stretch, normal);
}

static void write_leaf(const set_maker* m, uint32_t index)
{
    const stp_leaf_cell* leaf = &m->octree.leaves[index];
    const stp_leaf_properties* f = &m->properties[index];
    assert(index < m->splats->leaf_count && leaf->depth <= STP_LEAF_DEPTH_MAX);
    stp_splat_leaf* out = &m->splats->leaves[index];
    bool edge = f->edge;
    *out = (stp_splat_leaf){
        .corner = {leaf->corner[0], leaf->corner[1], leaf->corner[2]},
        .place = (uint8_t)(leaf->depth | (edge ? STP_LEAF_EDGE : 0) | STP_LEAF_ORIENTED),
        .extent = stp_leaf_extent_code(sqrtf(f->area) / (float)stp_leaf_width(leaf->depth)),
        .count = leaf->end - leaf->begin,
        .flatness = stp_leaf_flatness_code(f->min_flatness),
        .spread = (uint8_t)stp_min(f->spread * 255.0f + 0.999f, 255.0f)};
    stp_octahedral_encode(f->normal, out->normal);
}

/// Normal of a candidate. If its sign was a guess, it faces the side that its leaf's does.
static stp_vec3 normal_of(const set_maker* m, const stp_leaf_properties* f, uint32_t from)
{
    const float* n = m->candidates->normals + 3 * (size_t)from;
    stp_vec3 normal = {n[0], n[1], n[2]};
    bool against = !m->source->has_normals && stp_dot(normal, f->normal) < 0.0f;
    return against ? stp_scale(normal, -1.0f) : normal;
}

/// Requests the data of the next points, which lie far apart in memory.
static void prefetch_points(const set_maker* m, uint32_t begin, uint32_t count)
{
    const stp_candidates* c = m->candidates;
    uint32_t end = m->splats->count - begin < count ? m->splats->count : begin + count;
    for (uint32_t i = begin; i < end; ++i) {
        size_t from = m->octree.order[i];
        __builtin_prefetch(c->normals + 3 * from);
        __builtin_prefetch(m->places + 3 * from);
        __builtin_prefetch(c->colors + 4 * from);
        __builtin_prefetch(c->materials + from);
    }
}

/// Writes places [begin, end), at most BATCH, of one leaf.
/// @param next next index in each octave
static void write_batch(const set_maker* m, const leaf_shape* shape, uint32_t begin, uint32_t end,
                        uint32_t next[OCTAVES_MAX])
{
    float normals[3 * BATCH] = {0};
    int8_t codes[2 * BATCH];
    uint32_t at[BATCH];
    assert(begin < end && end - begin <= BATCH && end <= m->splats->count);
    const uint32_t* from = m->octree.order + begin;
    prefetch_points(m, end, BATCH);
    for (uint32_t i = 0; i < end - begin; ++i) {
        stp_vec3 n = normal_of(m, shape->properties, from[i]);
        memcpy(normals + 3 * i, &n, sizeof(n));
    }
    stp_octahedral_encode_many(normals, (end - begin + 7) / 8 * 8, codes); // whole vectors
    for (uint32_t i = 0; i < end - begin; ++i) {
        uint32_t octave = stp_leaf_octave_of(begin + i + 1, m->splats->octave_count);
        at[i] = next[octave]++;
        assert(at[i] < m->splats->octave_ends[octave]);
        write_splat(m, shape, from[i], codes + 2 * i, at[i]);
    }
    copy_attributes(m, from, at, end - begin);
}

static void write_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const set_maker* m = user;
    uint32_t octaves = m->splats->octave_count, count = m->splats->count;
    for (size_t l = begin; l < end; ++l) {
        const stp_leaf_cell* leaf = &m->octree.leaves[l];
        leaf_shape shape = shape_of_leaf(&m->properties[l]);
        uint32_t next[OCTAVES_MAX];
        for (uint32_t k = 0; k < octaves; ++k) {
            next[k] = stp_leaf_run_of(leaf->begin, leaf->begin, k, octaves, count).begin;
        }
        for (uint32_t i = leaf->begin; i < leaf->end; i += BATCH) {
            uint32_t last = leaf->end - i < BATCH ? leaf->end : i + BATCH;
            write_batch(m, &shape, i, last, next);
        }
        assert(next[octaves - 1] ==
                   stp_leaf_run_of(leaf->begin, leaf->end, octaves - 1, octaves, count).end &&
               "its run in the last octave is full");
        write_leaf(m, (uint32_t)l);
    }
}

/// Coverage radius of each prefix: the spacing of its sample, plus half the diagonal of a cell.
static void make_table(set_maker* m)
{
    stp_splats* s = m->splats;
    s->octave_count = stp_leaf_octaves(s->count);
    for (uint32_t k = 0; k < s->octave_count; ++k) {
        uint32_t end = stp_leaf_until(s->count, k, s->octave_count);
        float sparser = sqrtf((float)s->count / (float)end);
        s->octave_ends[k] = end;
        s->table.count[k] = end;
        s->table.radius[k] = s->step * (GROWTH * m->spacing * sparser + HALF_DIAGONAL);
    }
    assert(s->octave_count <= OCTAVES_MAX && s->octave_ends[s->octave_count - 1] == s->count);
    s->table.size = s->octave_count;
    double radius = m->candidates->surface_radius;
    radius = radius > 0.0 ? radius : m->candidates->pixel_size * 0.70710678118654752;
    s->candidate_radius = radius > 0.0 ? (float)radius : s->step * m->spacing * 0.70710678f;
}

static stp_result make_set(set_maker* m)
{
    stp_context* context = m->context;
    stp_splats* s = m->splats;
    uint32_t count = m->candidates->count;
    assert((m->source->shading_of_material != NULL || m->candidates->set_count == count) &&
           "only splats of sets have a shading");
    s->count = count < m->source->wanted ? count : m->source->wanted;
    choose_grid(m);
    m->places = STP_NEW_ARRAY(context, uint16_t, 3 * (size_t)count);
    if (m->places == NULL) {
        return stp_fail_memory(context);
    }
    stp_parallel_for(context, count, GRAIN, place_some, m);
    stp_result result =
        stp_leaf_octree_make(context, m->places, m->candidates->count, m->desc, SEED, &m->octree);
    if (result != STP_OK) {
        return result;
    }
    m->properties = STP_NEW_ARRAY(context, stp_leaf_properties, m->octree.leaf_count);
    result = m->properties == NULL ? stp_fail_memory(context) : find_properties(m);
    s->leaf_count = m->octree.leaf_count;
    s->leaves = STP_NEW_ARRAY(context, stp_splat_leaf, s->leaf_count);
    result = result == STP_OK && s->leaves == NULL ? stp_fail_memory(context) : result;
    result = result == STP_OK ? stp_splats_make_columns(context, s) : result;
    result = result == STP_OK ? allocate_attributes(m) : result;
    if (result == STP_OK) {
        make_table(m);
        stp_shape_directions_make(&m->directions);
        stp_parallel_for(context, s->leaf_count, LEAF_GRAIN, write_some, m);
    }
    return result;
}

stp_result stp_stochastic_make_set(stp_context* context, const stp_stochastic_source* source,
                                   const stp_leaf_desc* desc, stp_splats* splats)
{
    *splats = (stp_splats){.columns = STP_STOCHASTIC_COLUMNS};
    set_maker m = {.context = context,
                   .source = source,
                   .desc = desc,
                   .candidates = source->candidates,
                   .splats = splats};
    if (m.candidates->count == 0 || source->wanted == 0) {
        return STP_OK;
    }
    stp_result result = make_set(&m);
    stp_free(context, m.properties);
    stp_leaf_octree_destroy(context, &m.octree);
    stp_free(context, m.places);
    if (result != STP_OK) {
        stp_splats_destroy(context, splats);
        splats->columns = STP_STOCHASTIC_COLUMNS;
    }
    return result;
}

stp_result stp_stochastic_make_of_samples(stp_context* context, const stp_splats* samples,
                                          bool two_sided, const stp_leaf_desc* desc,
                                          stp_splats* splats)
{
    *splats = (stp_splats){.columns = STP_STOCHASTIC_COLUMNS};
    if (samples->count == 0) {
        return STP_OK;
    }
    stp_method_samples taken;
    stp_candidates candidates = {.count = samples->count,
                                 .set_count = samples->count,
                                 .surface_radius = (double)samples->candidate_radius};
    stp_result result = stp_method_samples_take(context, samples, NULL, &taken);
    candidates.colors = STP_NEW_ARRAY(context, uint8_t, 4 * (size_t)samples->count);
    candidates.materials = STP_NEW_ARRAY(context, uint32_t, samples->count);
    if (result == STP_OK && (candidates.colors == NULL || candidates.materials == NULL)) {
        result = stp_fail_memory(context);
    }
    for (size_t i = 0; i < samples->count && result == STP_OK; ++i) {
        memcpy(candidates.colors + 4 * i, taken.points.colors + 3 * i, 3);
        candidates.colors[4 * i + 3] = 255;
        candidates.materials[i] = samples->materials[i];
    }
    memcpy(candidates.attributes, samples->attributes, sizeof(candidates.attributes));
    if (result == STP_OK) {
        candidates.positions = taken.positions;
        candidates.normals = taken.normals;
        const stp_stochastic_source source = {.candidates = &candidates,
                                              .coverages = taken.coverages,
                                              .wanted = samples->count,
                                              .has_normals = !two_sided};
        result = stp_stochastic_make_set(context, &source, desc, splats);
    }
    stp_free(context, candidates.materials);
    stp_free(context, candidates.colors);
    stp_method_samples_destroy(context, &taken);
    return result;
}
