// SPDX-License-Identifier: MIT
//
// The area a disk must occlude, and the lines along which it may be clipped. All candidates in the
// disk's cylinder count, of any surface: a ray through the disk that hits any of them shows no
// background. So a plate with studs is as solid as a bare one, though each of its layers alone is
// full of holes. Geometry far behind the disk is a different object.
#include "base/splats/octahedral.h"
#include "lod/blue/pyramid.h"

#include <assert.h>
#include <string.h>

#define GRAIN 64
// Depth range in which candidates count, behind and in front of the disk, relative to the radius.
#define BEHIND 0.6f
#define BEFORE 1.0f
#define MIN_VIEW_FACING 0.3f // cosine: flatter views say little about a disk

enum { LANES = 8 };
_Static_assert(LANES <= (int)STP_GRID_LANES, "columns may be read so far beyond their end");

// One surfel's disk. Lengths are relative to its radius.
typedef struct disk {
    stp_vec3 place, normal;
    stp_vec3 x, y; ///< axes, over the radius
    float known;   ///< square of the minimum extent, once there is content on all sides
    stp_surroundings found;
} disk;

static disk make_disk(const stp_surroundings_search* s, uint32_t surfel)
{
    const float* at = s->pyramid->input->positions + 3 * (size_t)surfel;
    const float* n = s->pyramid->input->normals + 3 * (size_t)surfel;
    int8_t code[2];
    stp_octahedral_encode((stp_vec3){n[0], n[1], n[2]}, code);
    stp_disk_axes axes = stp_disk_axes_of((float)code[0], (float)code[1]);
    disk d = {.place = {at[0], at[1], at[2]},
              .normal = stp_octahedral_decode(code[0], code[1]),
              .x = stp_scale(axes.x, 1.0f / s->radius),
              .y = stp_scale(axes.y, 1.0f / s->radius)};
    for (int k = 0; k < STP_CLIP_DIRECTIONS; ++k) {
        d.found.reach[k] = -1.0f;
    }
    return d;
}

static void extend_reach(const stp_surroundings_search* s, disk* d, float u, float v)
{
    enum { HALF = STP_CLIP_DIRECTIONS / 2, PART = HALF / 3 };
    float* forth = d->found.reach;
    float* back = forth + HALF;
    float less[HALF];
    for (int k = 0; k < HALF; ++k) { // loops that vectorize
        float at = s->across[k] * u + s->along[k] * v;
        forth[k] = forth[k] > at ? forth[k] : at;
        back[k] = back[k] > -at ? back[k] : -at;
        less[k] = forth[k] < back[k] ? forth[k] : back[k];
    }
    for (int k = 0; k < PART; ++k) {
        less[k] = less[k] < less[k + PART] ? less[k] : less[k + PART];
        less[k] = less[k] < less[k + 2 * PART] ? less[k] : less[k + 2 * PART];
    }
    float minimum = 1.0f;
    for (int k = 0; k < PART; ++k) {
        minimum = minimum < less[k] ? minimum : less[k];
    }
    d->known = minimum > 0.0f ? minimum * minimum : 0.0f;
}

static uint32_t find_view(const uint32_t starts[STP_VIEWS_TOLD + 1], uint32_t index)
{
    assert(index < starts[STP_VIEWS_TOLD]);
    uint32_t view = 0;
    for (uint32_t k = 1; k < STP_VIEWS_TOLD; ++k) {
        view += index >= starts[k];
    }
    return view;
}

static void add_candidate(const stp_surroundings_search* s, disk* d, uint32_t i, float u, float v)
{
    const stp_grid* g = s->samples;
    d->found.cells |= stp_stencil_cells(u, v, s->footprint);
    float agreement = d->normal.x * g->nx[i] + d->normal.y * g->ny[i] + d->normal.z * g->nz[i];
    agreement = s->pyramid->input->finish->two_sided ? fabsf(agreement) : agreement;
    uint32_t index = g->index[i];
    assert(i < g->count && index < s->pyramid->input->finish->candidates->count);
    uint8_t alpha = s->pyramid->input->finish->candidates->colors[4 * (size_t)index + 3];
    float area = (float)stp_candidate_area(&s->pyramid->areas, index, alpha);
    d->found.total += area;
    area *= stp_max(agreement, 0.0f);
    d->found.area += area;
    if (s->view_starts != NULL && index < s->view_starts[STP_VIEWS_TOLD]) {
        d->found.views[find_view(s->view_starts, index)] += 1.0f;
    } else {
        d->found.others += area;
    }
    if (u * u + v * v > d->known) { // otherwise it lies within the known extent
        extend_reach(s, d, u, v);
    }
}

// Whether the requested result is complete.
static bool is_done(const stp_surroundings_search* s, const disk* d)
{
    return s->only_reach && d->known > s->reach_asked;
}

// Adds a candidate of a cloud: its cells and its extent.
static void add_point(const stp_surroundings_search* s, disk* d, float u, float v)
{
    d->found.cells |= stp_stencil_cells(u, v, s->footprint);
    if (u * u + v * v > d->known) {
        extend_reach(s, d, u, v);
    }
}

typedef float lanes_float __attribute__((vector_size(4 * LANES)));
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES)));

// Candidates in disk coordinates, LANES at a time.
typedef struct seen_lanes {
    lanes_float u, v;
    lanes_int inside; ///< -1 in those that are in the cylinder
} seen_lanes;

static void see_lanes(const stp_surroundings_search* s, const disk* d, uint32_t at, seen_lanes* out)
{
    const stp_grid* g = s->samples;
    lanes_float x, y, z;
    memcpy(&x, g->x + at, sizeof(x));
    memcpy(&y, g->y + at, sizeof(y));
    memcpy(&z, g->z + at, sizeof(z));
    x -= d->place.x;
    y -= d->place.y;
    z -= d->place.z;
    out->u = x * d->x.x + y * d->x.y + z * d->x.z;
    out->v = x * d->y.x + y * d->y.y + z * d->y.z;
    lanes_float height = x * d->normal.x + y * d->normal.y + z * d->normal.z;
    out->inside = (lanes_int)(out->u * out->u + out->v * out->v <= 1.0f);
    out->inside &= (lanes_int)(height >= -BEHIND * s->radius);
    out->inside &= (lanes_int)(height <= BEFORE * s->radius);
}

static void add_candidates(const stp_surroundings_search* s, disk* d, uint32_t begin, uint32_t end)
{
    for (uint32_t at = begin; at < end; at += LANES) {
        uint32_t count = end - at < LANES ? end - at : LANES;
        seen_lanes seen;
        see_lanes(s, d, at, &seen);
        for (uint32_t k = 0; k < count; ++k) {
            if (seen.inside[k] == 0) {
                continue;
            }
            if (s->only_reach) {
                add_point(s, d, seen.u[k], seen.v[k]);
            } else {
                add_candidate(s, d, at + k, seen.u[k], seen.v[k]);
            }
        }
    }
}

// Cells are at least as wide as the disk's radius, so a cylinder spans at most four of them on each
// axis: no two of these share a bucket. Cells of a row are consecutive within a block.
static void search_cylinder(const stp_surroundings_search* s, disk* d)
{
    const stp_grid* g = s->samples;
    float n[3] = {fabsf(d->normal.x), fabsf(d->normal.y), fabsf(d->normal.z)};
    float at[3] = {d->place.x, d->place.y, d->place.z}, r = s->radius;
    int32_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        float wide = r * sqrtf(stp_max(0.0f, 1.0f - n[k] * n[k])) + r * BEFORE * n[k];
        low[k] = stp_grid_cell(g, at[k] - wide);
        high[k] = stp_grid_cell(g, at[k] + wide);
        assert(high[k] - low[k] <= 3 && "cells of a cylinder share no bucket");
    }
    for (int32_t z = low[2]; z <= high[2]; ++z) {
        for (int32_t y = low[1]; y <= high[1] && !is_done(s, d); ++y) {
            for (int32_t x = low[0], last; x <= high[0]; x = last + 1) {
                last = (x | 3) < high[0] ? (x | 3) : high[0];
                uint32_t bucket = stp_grid_bucket(g, x, y, z);
                add_candidates(s, d, g->starts[bucket],
                               g->starts[bucket + (uint32_t)(last - x) + 1]);
            }
        }
    }
}

static void search_disks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const stp_surroundings_search* s = user;
    for (size_t i = begin; i < end; ++i) {
        disk d = make_disk(s, s->visit[i]);
        search_cylinder(s, &d);
        d.found.area *= (float)s->stride;
        d.found.others *= (float)s->stride;
        for (int k = 0; k < STP_VIEWS_TOLD; ++k) {
            float facing = fabsf(stp_dot(d.normal, s->views[k]));
            float covered = d.found.views[k] * (float)s->stride * s->pixel / facing;
            d.found.views[k] = facing >= MIN_VIEW_FACING ? covered : 0.0f;
        }
        d.found.total = stp_max(d.found.total * (float)s->stride, 1.0f);
        s->found[i] = d.found;
    }
}

// Shares per direction, if the capture has exactly the distinguished number of directions.
static void find_views(stp_surroundings_search* search)
{
    const stp_candidates* c = search->pyramid->input->finish->candidates;
    stp_vec3d directions[STP_VIEWS_TOLD];
    stp_capture_directions(STP_VIEWS_TOLD, directions);
    for (int k = 0; k < STP_VIEWS_TOLD; ++k) {
        search->views[k] = stp_to_float(directions[k]);
    }
    search->view_starts = c->direction_count == STP_VIEWS_TOLD ? c->view_starts : NULL;
    double pixels = (double)search->radius / c->pixel_size;
    search->pixel = (float)(1.0 / (STP_PI * pixels * pixels));
}

void stp_surroundings_search_run(stp_context* context, stp_surroundings_search* search)
{
    assert(search->count == 0 || (search->radius > 0.0f && search->stride > 0));
    assert(!(search->samples->cell < search->radius));
    find_views(search);
    for (uint32_t k = 0; k < STP_CLIP_DIRECTIONS / 2; ++k) {
        stp_disk_clip clip =
            stp_coverage_clip((uint8_t)(STP_COVERAGE_STRIPS + k * STP_CLIP_STRIP_OFFSETS));
        search->across[k] = clip.across;
        search->along[k] = clip.along;
    }
    stp_parallel_for(context, search->count, GRAIN, search_disks, search);
}

// Cells that a clipped disk draws: by their centres, or all cells that a narrow strip crosses.
static uint64_t cells_of(const stp_stencil* stencil, stp_disk_clip clip)
{
    uint64_t cells = 0;
    float middle = 0.5f * (clip.low + clip.high), half = 0.5f * (clip.high - clip.low);
    half = clip.low < -1.0f ? half : stp_max(half, 0.13f);
    for (int i = 0; i < 64; ++i) {
        float u = (float)(2 * (i & 7) - 7) / 8.0f, v = (float)(2 * (i >> 3) - 7) / 8.0f;
        float at = clip.across * u + clip.along * v - middle;
        cells |= fabsf(at) <= half ? (uint64_t)1 << i : 0;
    }
    return cells & stencil->disk;
}

void stp_clip_table_make(const stp_stencil* stencil, stp_clip_table* table)
{
    table->farthest = 0.0f;
    for (uint32_t code = STP_COVERAGE_HALVES; code < STP_COVERAGE_WHOLE; ++code) {
        table->clips[code] = stp_coverage_clip((uint8_t)code);
        table->cells[code] = cells_of(stencil, table->clips[code]);
        table->areas[code] = stp_coverage_area((uint8_t)code);
        assert(table->cells[code] != 0 && table->areas[code] > 0.0f);
        table->farthest = stp_max(table->farthest, table->clips[code].high);
    }
    table->cells[STP_COVERAGE_WHOLE] = stencil->disk;
    table->areas[STP_COVERAGE_WHOLE] = 1.0f;
}

// Smallest part of the disk that contains all its content, up to `slack`, relative to the radius.
uint8_t stp_clip_choose(const stp_clip_table* table, const stp_surroundings* found, float slack)
{
    uint8_t best = STP_COVERAGE_WHOLE;
    for (uint32_t code = STP_COVERAGE_HALVES; code < STP_COVERAGE_WHOLE; ++code) {
        bool half = code < STP_COVERAGE_STRIPS;
        uint32_t at = code - (uint32_t)(half ? STP_COVERAGE_HALVES : STP_COVERAGE_STRIPS);
        uint32_t direction = at / (half ? STP_CLIP_HALF_OFFSETS : STP_CLIP_STRIP_OFFSETS);
        uint32_t opposite = (direction + STP_CLIP_DIRECTIONS / 2) % STP_CLIP_DIRECTIONS;
        assert(direction < STP_CLIP_DIRECTIONS);
        const stp_disk_clip* clip = &table->clips[code];
        if (found->reach[direction] <= clip->high + slack &&
            -found->reach[opposite] >= clip->low - slack &&
            table->areas[code] < table->areas[best]) {
            best = (uint8_t)code;
        }
    }
    return best;
}
