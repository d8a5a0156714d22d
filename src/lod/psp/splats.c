// SPDX-License-Identifier: MIT
#include "lod/psp/splats.h"

#include "base/coverage.h"
#include "base/octahedral.h"
#include "base/prefix_table.h"
#include "base/splat_codes.h"
#include "lod/psp/forest.h"
#include "lod/psp/sequence.h"
#include "lod/samples.h"
#include "lod/set_table.h"
#include "lod/surfels.h"

#include <float.h>
#include <string.h>

enum { GRAIN = 1024 }; ///< splats
#define PI 3.14159265358979323846
#define CELL 1.2f ///< area of a sample, in squares of the radius that all samples cover to
#define GROWTH                                                                                     \
    1.1f ///< drawn ellipses overlap a little, because outlines of regions are not ellipses
#define MARGIN 0.38f ///< of that radius: how far a sample's disk reaches beyond a disk of its area
#define SCATTERED 0.3f ///< share of an ellipse that is surface, below which pixels are left out
#define LEAST_SHARE (1.0f / 255.0f) ///< of a sample's disk that is surface
#define HALF_DIAGONAL 0.8660254f    ///< of a cube of side 1

typedef struct psp_maker {
    stp_context* context;
    const stp_splats* samples;
    stp_splats* splats;
    stp_method_samples points;
    float* areas; ///< of splats of the forest: the surface that they stand for
    stp_psp_forest forest;
    stp_psp_sequence sequence;
    uint32_t* counts;                    ///< of merges: samples
    uint8_t* materials;                  ///< of splats of the forest
    float reach, cell;                   ///< to what all samples cover; area of a sample
    stp_shape_axis axes[STP_SHAPE_TURN]; ///< directions of the larger radius, by code
} psp_maker;

static stp_result make_forest(psp_maker* m)
{
    const stp_tree_points* p = &m->points.points;
    m->reach = stp_prefix_table_radius(&m->samples->table, m->samples->count);
    m->cell = CELL * m->reach * m->reach;
    if (!(m->cell > FLT_MIN)) { // samples of few places
        m->cell = fmaxf(m->samples->step * m->samples->step, FLT_MIN);
    }
    m->areas = STP_NEW_ARRAY(m->context, float, 2 * (size_t)p->count + 1);
    if (m->areas == NULL) {
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        m->areas[i] = m->cell * fmaxf(stp_coverage_area(m->points.coverages[i]), LEAST_SHARE);
    }
    const stp_psp_points from = {.count = p->count,
                                 .positions = p->positions,
                                 .normals = p->normals,
                                 .colors = p->colors,
                                 .areas = m->areas};
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = STP_PSP_REGIONS;
    desc.connect_components = true;
    return stp_psp_forest_make(m->context, &from, &desc, 1, &m->forest);
}

static stp_result make_columns(psp_maker* m)
{
    stp_splats* s = m->splats;
    size_t count = s->count;
    s->positions = STP_NEW_ARRAY(m->context, uint16_t, 3 * count);
    s->normals = STP_NEW_ARRAY(m->context, int8_t, 2 * count);
    s->materials = STP_NEW_ARRAY(m->context, uint8_t, count);
    s->colors = STP_NEW_ARRAY(m->context, uint8_t, 3 * count);
    s->coverages = STP_NEW_ARRAY(m->context, uint8_t, count);
    s->shapes = STP_NEW_ARRAY(m->context, uint32_t, count);
    s->ranges = STP_NEW_ARRAY(m->context, uint32_t, count);
    m->materials = STP_NEW_ARRAY(m->context, uint8_t, count);
    m->counts = STP_NEW_ARRAY(m->context, uint32_t, count);
    bool made = s->positions != NULL && s->normals != NULL && s->materials != NULL &&
                s->colors != NULL && s->coverages != NULL && s->shapes != NULL &&
                s->ranges != NULL && m->materials != NULL && m->counts != NULL;
    return made ? STP_OK : stp_fail_memory(m->context);
}

static uint16_t to_grid(float x, float origin, float step)
{
    float value = (x - origin) / step + 0.5f;
    return value > 0.0f ? (value < 65535.0f ? (uint16_t)value : 65535) : 0;
}

/// The code of the direction nearest to the larger axis of an ellipse.
static uint32_t find_direction(const psp_maker* m, const int8_t* normal, stp_vec3 major)
{
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    float x = stp_dot(major, axes.x), y = stp_dot(major, axes.y), best = -1.0f;
    uint32_t code = 0;
    for (uint32_t i = 0; i < STP_SHAPE_TURN; ++i) {
        float along = fabsf(x * m->axes[i].along_x + y * m->axes[i].along_y);
        if (along > best) {
            best = along;
            code = i;
        }
    }
    return code;
}

static uint32_t find_shape(const psp_maker* m, float major, float minor, const int8_t* normal,
                           stp_vec3 axis)
{
    float step = m->splats->step;
    uint32_t larger = stp_shape_code(major / step + HALF_DIAGONAL);
    uint32_t smaller = stp_shape_code(minor / step + HALF_DIAGONAL);
    if (smaller >= larger) {
        return stp_shape_disk(stp_shape_radius(larger), STP_SHAPE_SPREAD_ANY, false);
    }
    return larger | smaller << 12 | find_direction(m, normal, axis) << 24;
}

/// The shape and the coverage of a splat that was merged.
static void fill_merged(const psp_maker* m, uint32_t splat, uint32_t at)
{
    const stp_ellipse* e = &m->forest.ellipses[splat];
    float major = stp_length(e->major), minor = e->minor, area = m->areas[splat];
    float share = area / (float)(PI * (double)major * (double)minor);
    bool scattered = share < SCATTERED;
    // what covers a small part of its samples' disks, such as wires, does not reach out by all of the margin
    float filled = area / ((float)m->counts[splat - m->forest.point_count] * m->cell);
    float margin = MARGIN * m->reach * fminf(filled, 1.0f);
    float scale = scattered ? 1.0f : GROWTH;
    m->splats->coverages[at] =
        scattered ? stp_coverage_of_share((double)share) : STP_COVERAGE_WHOLE;
    m->splats->shapes[at] = find_shape(m, major * scale + margin, minor * scale + margin,
                                       m->splats->normals + 2 * (size_t)at, e->major);
}

static void fill_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const psp_maker* m = user;
    const stp_splats* s = m->splats;
    (void)worker;
    for (size_t at = begin; at < end; ++at) {
        uint32_t splat = m->sequence.splats[at];
        const stp_ellipse* e = &m->forest.ellipses[splat];
        bool merged = splat >= m->forest.point_count;
        // samples stay as they are
        memcpy(s->positions + 3 * at, m->samples->positions + 3 * (size_t)(merged ? 0 : splat),
               3 * sizeof(uint16_t));
        memcpy(s->normals + 2 * at, m->samples->normals + 2 * (size_t)(merged ? 0 : splat), 2);
        memcpy(s->colors + 3 * at, m->forest.colors + 3 * (size_t)splat, 3);
        s->materials[at] = m->materials[splat];
        s->ranges[at] = m->sequence.ranges[at];
        if (merged) {
            s->positions[3 * at] = to_grid(e->center.x, s->origin.x, s->step);
            s->positions[3 * at + 1] = to_grid(e->center.y, s->origin.y, s->step);
            s->positions[3 * at + 2] = to_grid(e->center.z, s->origin.z, s->step);
            stp_octahedral_encode(e->normal, s->normals + 2 * at);
            fill_merged(m, splat, (uint32_t)at);
        } else {
            float radius = m->points.points.radius / s->step;
            s->coverages[at] = m->points.coverages[splat];
            s->shapes[at] = stp_shape_disk(radius, STP_SHAPE_SPREAD_ANY, false);
        }
    }
}

/// How many samples each merge has. Its material is that of the larger of the two parts.
static void find_materials(const psp_maker* m)
{
    const stp_psp_forest* f = &m->forest;
    memcpy(m->materials, m->samples->materials, f->point_count);
    for (uint32_t i = 0; i < f->merge_count; ++i) {
        const uint32_t parts[2] = {f->merges[i].left, f->merges[i].right};
        uint32_t larger = m->areas[parts[0]] >= m->areas[parts[1]] ? parts[0] : parts[1];
        m->materials[f->point_count + i] = m->materials[larger];
        m->counts[i] = 0;
        m->areas[f->point_count + i] = m->areas[parts[0]] + m->areas[parts[1]];
        for (int k = 0; k < 2; ++k) {
            m->counts[i] += parts[k] < f->point_count ? 1 : m->counts[parts[k] - f->point_count];
        }
    }
}

static void find_axes(psp_maker* m)
{
    for (uint32_t i = 0; i < STP_SHAPE_TURN; ++i) {
        stp_shape_axis smaller = stp_shape_smaller(i << 24);
        m->axes[i] = (stp_shape_axis){-smaller.along_y, smaller.along_x};
    }
}

static stp_result make(psp_maker* m)
{
    stp_splats* s = m->splats;
    stp_result result = stp_method_samples_take(m->context, m->samples, &m->points);
    result = result == STP_OK ? make_forest(m) : result;
    result =
        result == STP_OK ? stp_psp_sequence_make(m->context, &m->forest, &m->sequence) : result;
    if (result != STP_OK) {
        return result;
    }
    s->columns = STP_PSP_COLUMNS;
    s->origin = m->samples->origin;
    s->step = m->samples->step;
    s->candidate_radius = m->samples->candidate_radius;
    s->count = m->sequence.count;
    result = make_columns(m);
    if (result == STP_OK) {
        stp_set_octaves_make(s);
        stp_set_table_make(s, m->sequence.highest_left, 1.0f, m->reach);
        find_materials(m);
        find_axes(m);
        stp_parallel_for(m->context, s->count, GRAIN, fill_some, m);
    }
    return result;
}

stp_result stp_psp_make(stp_context* context, const stp_splats* samples, stp_splats* splats)
{
    psp_maker m = {.context = context, .samples = samples, .splats = splats};
    *splats = (stp_splats){.columns = STP_PSP_COLUMNS};
    if (samples->count == 0) {
        return STP_OK;
    }
    stp_result result = make(&m);
    stp_psp_sequence_destroy(context, &m.sequence);
    stp_psp_forest_destroy(context, &m.forest);
    stp_free(context, m.areas);
    stp_free(context, m.materials);
    stp_free(context, m.counts);
    stp_method_samples_destroy(context, &m.points);
    if (result != STP_OK) {
        stp_splats_destroy(context, splats);
    }
    return result;
}
