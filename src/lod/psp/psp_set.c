// SPDX-License-Identifier: MIT
#include "lod/psp/psp_set.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/prefix_table.h"
#include "lod/psp/forest.h"
#include "lod/samples.h"
#include "lod/set_columns.h"

#include <assert.h>
#include <float.h>
#include <string.h>

enum { GRAIN = 1024 }; ///< splats per piece of a parallel loop
#define PI 3.14159265358979323846
#define CELL 1.2f ///< area of a sample, relative to the squared coverage radius of all samples
/// Scale of drawn ellipses: they overlap slightly, because regions are not exactly elliptical
#define GROWTH 1.1f
/// Spacing of points, in candidate radii. Used if all points of a cloud are samples: then the
/// coverage radius is 0
#define SPACING 1.4142135f
/// Extent of a sample's disk beyond a disk of its area, relative to the coverage radius
#define MARGIN 0.38f
#define SCATTERED 0.3f ///< minimum surface share of an ellipse; below it, pixels are skipped
#define MIN_SHARE (1.0f / 255.0f) ///< minimum surface share of a sample's disk
#define HALF_DIAGONAL 0.8660254f  ///< half the diagonal of a unit cube

typedef struct psp_maker {
    stp_context* context;
    const stp_splats* samples;
    const stp_shading* shadings; ///< of the samples, for their growths; NULL: none
    stp_psp_metric metric;
    bool two_sided;
    uint32_t limit; ///< of splats in a state; 0: none
    stp_splats* splats;
    stp_method_samples points;
    float* areas; ///< per splat of the forest: represented surface area
    stp_psp_forest forest;
    stp_psp_sequence sequence;
    float* disks;  ///< per splat: area of its samples' whole disks; 1: one of the common radius
    float* widest; ///< per splat: largest radius of its samples, in common radii
    uint8_t* materials; ///< per splat of the forest
    float reach;        ///< coverage radius of all samples over the candidates
    float spacing;      ///< coverage radius over the surface
    float cell;         ///< area of a sample
    stp_shape_directions directions;
} psp_maker;

static stp_result make_forest(psp_maker* m)
{
    const stp_tree_points* p = &m->points.points;
    m->reach = stp_prefix_table_radius(&m->samples->table, m->samples->count);
    m->spacing = fmaxf(m->reach, SPACING * m->samples->candidate_radius);
    m->cell = CELL * m->spacing * m->spacing;
    if (!(m->cell > FLT_MIN)) { // few distinct sample positions
        m->cell = fmaxf(m->samples->step * m->samples->step, FLT_MIN);
    }
    assert(m->cell > 0.0f);
    m->areas = STP_NEW_ARRAY(m->context, float, 2 * (size_t)p->count + 1);
    m->disks = STP_NEW_ARRAY(m->context, float, 2 * (size_t)p->count + 1);
    m->widest = STP_NEW_ARRAY(m->context, float, 2 * (size_t)p->count + 1);
    if (m->areas == NULL || m->disks == NULL || m->widest == NULL) {
        return stp_fail_memory(m->context);
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        float radius =
            m->points.radii != NULL && p->radius > 0.0f ? m->points.radii[i] / p->radius : 1.0f;
        m->widest[i] = radius;
        m->disks[i] = radius * radius;
        m->areas[i] =
            m->cell * m->disks[i] * fmaxf(stp_coverage_area(m->points.coverages[i]), MIN_SHARE);
    }
    const stp_psp_points from = {.count = p->count,
                                 .positions = p->positions,
                                 .normals = p->normals,
                                 .colors = p->colors,
                                 .areas = m->areas};
    stp_psp_desc desc = stp_psp_desc_default();
    desc.metric = m->metric;
    desc.two_sided = m->two_sided;
    desc.connect_components = true;
    stp_result result = stp_psp_forest_make(m->context, &from, &desc, 1, &m->forest);
    if (result == STP_OK && m->metric != STP_PSP_REGIONS) {
        result = stp_psp_measure_pictures(m->context, &from, m->two_sided, &m->forest);
    }
    return result;
}

/// Margin around the ellipse of a merge by one of the paper's metrics, so that it covers the drawn
/// samples: STP_PSP_NORMALS covers disks that reach beyond them, STP_PSP_DISTANCES their centres.
static float margin_of_cover(const psp_maker* m, uint32_t splat)
{
    return m->metric == STP_PSP_DISTANCES ? m->points.points.radius * m->widest[splat] : 0.0f;
}

/// Shape and coverage of a merged splat.
static void fill_merged(const psp_maker* m, uint32_t splat, uint32_t at)
{
    const stp_ellipse* e = &m->forest.ellipses[splat];
    float major = stp_length(e->major), minor = e->minor, area = m->areas[splat];
    bool covers = m->metric != STP_PSP_REGIONS;
    float share = area / (float)(PI * (double)major * (double)minor);
    bool scattered = !covers && share < SCATTERED;
    // splats that cover little of their samples' disks, such as wires, get only part of the margin
    float filled = area / (m->disks[splat] * m->cell);
    float beyond = MARGIN * m->spacing * m->widest[splat];
    float margin = covers ? margin_of_cover(m, splat) : beyond * fminf(filled, 1.0f);
    float scale = scattered || covers ? 1.0f : GROWTH;
    m->splats->coverages[at] =
        scattered ? stp_coverage_of_share((double)share) : STP_COVERAGE_WHOLE;
    float step = m->splats->step; // rounding moves centres by up to half the diagonal of a cell
    m->splats->shapes[at] =
        stp_shape_of_ellipse(&m->directions, (major * scale + margin) / step + HALF_DIAGONAL,
                             (minor * scale + margin) / step + HALF_DIAGONAL, e->major,
                             m->splats->normals + 2 * (size_t)at);
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
        s->materials[at] = m->materials[splat];
        s->ranges[at] = m->sequence.ranges[at];
        memcpy(s->colors + 3 * at, m->forest.colors + 3 * (size_t)splat, 3);
        if (merged) {
            s->positions[3 * at] = stp_splats_grid_place(e->center.x, s->origin.x, s->step);
            s->positions[3 * at + 1] = stp_splats_grid_place(e->center.y, s->origin.y, s->step);
            s->positions[3 * at + 2] = stp_splats_grid_place(e->center.z, s->origin.z, s->step);
            stp_octahedral_encode(e->normal, s->normals + 2 * at);
            fill_merged(m, splat, (uint32_t)at);
        } else { // samples are unchanged
            float radius = stp_method_samples_radius(&m->points, splat) / s->step;
            memcpy(s->positions + 3 * at, m->samples->positions + 3 * (size_t)splat,
                   3 * sizeof(uint16_t));
            memcpy(s->normals + 2 * at, m->samples->normals + 2 * (size_t)splat, 2);
            s->coverages[at] = m->points.coverages[splat];
            s->shapes[at] =
                stp_shape_of_ellipse(&m->directions, radius, radius, e->major, s->normals + 2 * at);
        }
    }
}

/// Adds up the areas of each merge, and gives it the material of its larger part.
static void find_materials(const psp_maker* m)
{
    const stp_psp_forest* f = &m->forest;
    memcpy(m->materials, m->samples->materials, f->point_count);
    for (uint32_t i = 0; i < f->merge_count; ++i) {
        const uint32_t parts[2] = {f->merges[i].left, f->merges[i].right};
        assert(parts[0] < f->point_count + i && parts[1] < f->point_count + i && "parts are done");
        uint32_t larger = m->areas[parts[0]] >= m->areas[parts[1]] ? parts[0] : parts[1];
        m->materials[f->point_count + i] = m->materials[larger];
        uint32_t merged = f->point_count + i;
        m->areas[merged] = m->areas[parts[0]] + m->areas[parts[1]];
        m->disks[merged] = m->disks[parts[0]] + m->disks[parts[1]];
        m->widest[merged] = fmaxf(m->widest[parts[0]], m->widest[parts[1]]);
    }
}

static stp_result make(psp_maker* m)
{
    stp_splats* s = m->splats;
    stp_result result = stp_method_samples_take(m->context, m->samples, m->shadings, &m->points);
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
    float left_out = 0.0f;
    if (m->limit != 0) {
        result = stp_psp_sequence_shorten(m->context, &m->sequence, m->limit, &left_out);
    }
    s->count = m->sequence.count;
    assert(m->limit != 0 || s->count >= m->samples->count); // all samples are splats
    size_t all = (size_t)m->forest.point_count + m->forest.merge_count;
    m->materials = STP_NEW_ARRAY(m->context, uint8_t, all);
    result = result == STP_OK ? stp_splats_make_columns(m->context, s) : result;
    if (result == STP_OK && m->materials == NULL) {
        result = stp_fail_memory(m->context);
    }
    if (result == STP_OK) {
        stp_set_octaves_make(s);
        stp_set_table_make(s, m->sequence.highest_left, 1.0f, fmaxf(m->reach, left_out));
        find_materials(m);
        stp_shape_directions_make(&m->directions);
        stp_parallel_for(m->context, s->count, GRAIN, fill_some, m);
    }
    return result;
}

stp_result stp_psp_make(stp_context* context, const stp_splats* samples,
                        const stp_shading* shadings, bool two_sided, stp_psp_metric metric,
                        uint32_t limit, stp_splats* splats)
{
    psp_maker m = {.context = context,
                   .samples = samples,
                   .shadings = shadings,
                   .metric = metric,
                   .two_sided = two_sided,
                   .limit = limit,
                   .splats = splats};
    *splats = (stp_splats){.columns = STP_PSP_COLUMNS};
    if (samples->count == 0) {
        return STP_OK;
    }
    stp_result result = make(&m);
    stp_psp_sequence_destroy(context, &m.sequence);
    stp_psp_forest_destroy(context, &m.forest);
    stp_free(context, m.areas);
    stp_free(context, m.materials);
    stp_free(context, m.disks);
    stp_free(context, m.widest);
    stp_method_samples_destroy(context, &m.points);
    if (result != STP_OK) {
        stp_splats_destroy(context, splats);
    }
    return result;
}
