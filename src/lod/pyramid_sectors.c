// SPDX-License-Identifier: MIT
//
// Corners and borders. The surfel at a corner has little surface of its own, as one on a wire has; but all of its
// surface lies in one quarter of its disk, and fills it. So the disk is looked at in eight sectors of 45 degrees: what
// counts is the fullest two that lie side by side.
#include "lod/pyramid.h"

#define GRAIN 256
#define LEAST_AGREEMENT 0.3f // cosine: what faces aside is another surface
#define MOST_RISE 0.35f      // and so is what lies so far before or behind the disk, in radii

// What samples stand for: candidates, or surfels of a finer octave.
static float sample_area(const stp_sector_search* s, uint32_t index)
{
    if (s->entries != NULL) {
        return s->entries[index].area;
    }
    uint8_t alpha = s->pyramid->input->finish->candidates->colors[4 * (size_t)index + 3];
    return (float)stp_candidate_area(&s->pyramid->areas, index, alpha);
}

// One surfel's disk.
typedef struct disk {
    stp_vec3 place, normal, across, along;
    float sectors[8]; ///< areas
} disk;

static disk make_disk(const stp_pyramid* p, uint32_t surfel)
{
    const float* at = p->input->positions + 3 * (size_t)surfel;
    const float* n = p->input->normals + 3 * (size_t)surfel;
    disk d = {.place = {at[0], at[1], at[2]}, .normal = {n[0], n[1], n[2]}};
    float x = fabsf(n[0]), y = fabsf(n[1]), z = fabsf(n[2]);
    stp_vec3 axis = {x <= y && x <= z, y < x && y <= z, z < x && z < y};
    d.across = stp_normalize(stp_cross(d.normal, axis));
    d.along = stp_cross(d.normal, d.across);
    return d;
}

static void add_samples(const stp_sector_search* s, disk* d, uint32_t begin, uint32_t end)
{
    const stp_grid* g = s->samples;
    float limit = s->radius * s->radius, rise = MOST_RISE * s->radius;
    for (uint32_t i = begin; i < end; ++i) {
        stp_vec3 offset = {g->x[i] - d->place.x, g->y[i] - d->place.y, g->z[i] - d->place.z};
        float agreement = d->normal.x * g->nx[i] + d->normal.y * g->ny[i] + d->normal.z * g->nz[i];
        if (stp_dot(offset, offset) > limit || agreement < LEAST_AGREEMENT ||
            fabsf(stp_dot(offset, d->normal)) > rise) {
            continue;
        }
        float u = stp_dot(offset, d->across), v = stp_dot(offset, d->along);
        int sector = v < 0.0f ? 4 : 0; // counted around the disk
        float a = v < 0.0f ? -u : u, b = fabsf(v);
        sector += a >= 0.0f ? (a >= b ? 0 : 1) : (-a < b ? 2 : 3);
        d->sectors[sector] += sample_area(s, g->index[i]) * agreement;
    }
}

// The grid's cells are as wide as the disk's radius or wider: it reaches three of them on each axis at most.
static void look_around(const stp_sector_search* s, disk* d)
{
    const stp_grid* g = s->samples;
    float r = s->radius;
    int32_t low[3] = {stp_grid_cell(g, d->place.x - r), stp_grid_cell(g, d->place.y - r),
                      stp_grid_cell(g, d->place.z - r)};
    int32_t high[3] = {stp_grid_cell(g, d->place.x + r), stp_grid_cell(g, d->place.y + r),
                       stp_grid_cell(g, d->place.z + r)};
    for (int32_t z = low[2]; z <= high[2]; ++z) {
        for (int32_t y = low[1]; y <= high[1]; ++y) {
            for (int32_t x = low[0]; x <= high[0]; ++x) {
                uint32_t bucket = stp_grid_bucket(g, x, y, z);
                add_samples(s, d, g->starts[bucket], g->starts[bucket + 1]);
            }
        }
    }
}

static void search_sectors(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const stp_sector_search* s = user;
    for (size_t i = begin; i < end; ++i) {
        disk d = make_disk(s->pyramid, s->visit[i]);
        look_around(s, &d);
        float fullest = 0.0f;
        for (int k = 0; k < 8; ++k) {
            fullest = stp_max(fullest, d.sectors[k] + d.sectors[(k + 1) & 7]);
        }
        s->fullest[i] = fullest * (float)s->stride;
    }
}

void stp_sector_search_run(stp_context* context, stp_sector_search* search)
{
    stp_parallel_for(context, search->count, GRAIN, search_sectors, search);
}
