// SPDX-License-Identifier: MIT
#include "lod/neighbours.h"

#include "base/core/processor.h"
#include "base/math/math.h"
#include "lod/neighbours_kernels.h"

#include <assert.h>
#include <string.h>

#define BUCKET_GRAIN 1024
#define SURFEL_GRAIN 512
#define KNOWN_LIMIT 64u
#define AHEAD 8u // surfels to prefetch ahead

const stp_near_kernels* stp_near_kernels_select(void)
{
    return STP_VARIANT_OF_TWO(stp_processor_detect(), &stp_near_kernels);
}

// Surfels that may be near the samples of one cell: those of the 2 x 2 x 2 cells around its centre.
// No two of these share a bucket. Neighbours in x are consecutive in memory within a block.
static void find_ranges(const stp_grid* grid, const int32_t cell[3], stp_near_ranges* ranges)
{
    uint32_t together = (cell[0] & 3) < 3 ? 2 : 1;
    ranges->count = 0;
    for (int corner = 0; corner < 8; corner += (int)together) {
        uint32_t bucket = stp_grid_bucket(grid, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                                          cell[2] + (corner >> 2));
        assert(bucket + together <= grid->mask + 1 && "they are in one block of buckets");
        stp_near_ranges_add(ranges, grid->starts[bucket], grid->starts[bucket + together]);
    }
}

typedef struct nearest_job {
    const stp_nearest_search* search;
    const stp_near_kernels* kernels;
    stp_near_rule rule;
} nearest_job;

static void search_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const nearest_job* job = user;
    const stp_grid* samples = job->search->samples;
    const stp_grid* surfels = job->search->surfels;
    stp_near_ranges ranges;
    for (size_t bucket = begin; bucket < end; ++bucket) {
        uint32_t last = samples->starts[bucket + 1];
        for (uint32_t at = samples->starts[bucket], run; at < last; at = run) {
            int32_t cell[3] = {stp_grid_cell(samples, samples->x[at]),
                               stp_grid_cell(samples, samples->y[at]),
                               stp_grid_cell(samples, samples->z[at])};
            run = job->kernels->find_run(samples, at, last); // mostly all of a bucket
            assert(at < run && run <= last);
            find_ranges(surfels, cell, &ranges);
            job->kernels->find_nearest(surfels, &ranges, samples, at, run, job->rule,
                                       job->search->nearest);
        }
    }
}

void stp_nearest_search_run(stp_context* context, const stp_nearest_search* search)
{
    assert(search->samples->cell == search->surfels->cell);
    assert(search->surfels->offset == 0.0f);
    assert(search->samples->offset == 0.5f * search->samples->cell);
    assert(!(search->surfels->cell < 2.0f * search->radius) && "2 x 2 x 2 cells suffice");
    nearest_job job = {.search = search,
                       .kernels = stp_near_kernels_select(),
                       .rule = {.limit = search->radius * search->radius,
                                .min_agreement = search->two_sided ? -2.0f : 0.0f}};
    stp_parallel_for(context, (size_t)search->samples->mask + 1, BUCKET_GRAIN, search_buckets,
                     &job);
}

// State of one surfel's disk during the search.
typedef struct disk_scan {
    const stp_disk_search* search;
    const stp_near_kernels* kernels;
    stp_disk_query query;
    stp_disk disk;
    int32_t low[3], high[3];     ///< cells
    stp_near_ranges ranges;      ///< ranges of samples to test
    uint32_t known_count;        ///< visited buckets
    uint32_t known[KNOWN_LIMIT]; ///< start of the last ones
} disk_scan;

// Adds the cells from x to `last` of a row, within one block of buckets.
static void add_cells(disk_scan* scan, int32_t x, int32_t last, int32_t y, int32_t z)
{
    const stp_grid* samples = scan->search->samples;
    assert(x <= last && (x | 3) == (last | 3) && "they are in one block of buckets");
    uint32_t bucket = stp_grid_bucket(samples, x, y, z);
    stp_near_ranges_add(&scan->ranges, samples->starts[bucket],
                        samples->starts[bucket + (uint32_t)(last - x) + 1]);
}

// Adds a row of cells, except the middle one, which was tested first.
static void add_row(disk_scan* scan, const int32_t middle[3], int32_t y, int32_t z)
{
    bool own = y == middle[1] && z == middle[2];
    for (int32_t x = scan->low[0]; x <= scan->high[0];) {
        int32_t last = (x | 3) < scan->high[0] ? (x | 3) : scan->high[0];
        if (own && x <= middle[0] && middle[0] <= last) {
            if (x < middle[0]) {
                add_cells(scan, x, middle[0] - 1, y, z);
            }
            if (middle[0] < last) {
                add_cells(scan, middle[0] + 1, last, y, z);
            }
        } else {
            add_cells(scan, x, last, y, z);
        }
        x = last + 1;
    }
}

// Tests the samples of all ranges. @return whether the disk is finished
static bool scan_ranges(disk_scan* scan)
{
    bool done =
        scan->kernels->scan_disk(scan->search->samples, &scan->ranges, &scan->query, &scan->disk);
    scan->ranges.count = 0;
    return done;
}

// Cells four or more apart may share a bucket; visits a bucket once, if it is among the last
// KNOWN_LIMIT visited.
static bool is_known(disk_scan* scan, uint32_t begin)
{
    uint32_t known = scan->known_count < KNOWN_LIMIT ? scan->known_count : KNOWN_LIMIT;
    for (uint32_t i = 0; i < known; ++i) {
        if (scan->known[i] == begin) {
            return true;
        }
    }
    scan->known[scan->known_count++ % KNOWN_LIMIT] = begin;
    return false;
}

static void scan_many_cells(disk_scan* scan)
{
    const stp_grid* samples = scan->search->samples;
    bool done = false;
    for (int32_t z = scan->low[2]; !done && z <= scan->high[2]; ++z) {
        for (int32_t y = scan->low[1]; !done && y <= scan->high[1]; ++y) {
            for (int32_t x = scan->low[0]; !done && x <= scan->high[0]; ++x) {
                uint32_t bucket = stp_grid_bucket(samples, x, y, z);
                uint32_t begin = samples->starts[bucket], end = samples->starts[bucket + 1];
                if (begin != end && !is_known(scan, begin)) {
                    stp_near_ranges_add(&scan->ranges, begin, end);
                    done = scan_ranges(scan);
                }
            }
        }
    }
}

static void scan_disk(disk_scan* scan)
{
    const stp_grid* samples = scan->search->samples;
    float reach = scan->search->radius + scan->search->footprint;
    float place[3] = {scan->query.x, scan->query.y, scan->query.z};
    int32_t middle[3], widest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        scan->low[axis] = stp_grid_cell(samples, place[axis] - reach);
        scan->high[axis] = stp_grid_cell(samples, place[axis] + reach);
        middle[axis] = stp_grid_cell(samples, place[axis]);
        int32_t wide = scan->high[axis] - scan->low[axis];
        widest = wide > widest ? wide : widest;
    }
    if (widest > 3) {
        scan_many_cells(scan);
        return;
    }
    add_cells(scan, middle[0], middle[0], middle[1], middle[2]);
    if (scan_ranges(scan)) { // most disks are full, which is found here
        return;
    }
    for (int32_t z = scan->low[2]; z <= scan->high[2]; ++z) {
        for (int32_t y = scan->low[1]; y <= scan->high[1]; ++y) {
            add_row(scan, middle, y, z);
        }
    }
    (void)scan_ranges(scan);
}

typedef struct disk_job {
    const stp_disk_search* search;
    const stp_near_kernels* kernels;
} disk_job;

static stp_disk_query make_query(const stp_disk_search* s, uint32_t surfel)
{
    const float* p = s->positions + 3 * (size_t)surfel;
    const float* n = s->normals + 3 * (size_t)surfel;
    float limit = s->radius + s->footprint;
    stp_disk_query query = {.x = p[0],
                            .y = p[1],
                            .z = p[2],
                            .nx = n[0],
                            .ny = n[1],
                            .nz = n[2],
                            .limit = limit * limit,
                            .min_agreement = s->two_sided ? -2.0f : 0.0f,
                            .footprint = s->footprint / s->radius,
                            .set_footprint = s->set_footprint / s->radius,
                            .first_of_sets = UINT32_MAX,
                            .set_weight = s->set_weight,
                            .fractions = s->fractions,
                            .stencil = s->stencil,
                            .until_full = s->until_full};
    if (s->set_count != 0) {
        query.first_of_sets = s->sample_count - s->set_count;
    }
    float x = fabsf(n[0]), y = fabsf(n[1]), z = fabsf(n[2]);
    stp_vec3 normal = {n[0], n[1], n[2]};
    stp_vec3 axis = {x <= y && x <= z, y < x && y <= z, z < x && z < y};
    stp_vec3 tangent = stp_normalize(stp_cross(normal, axis));
    query.tangents[0] = stp_scale(tangent, 1.0f / s->radius);
    query.tangents[1] = stp_scale(stp_cross(normal, tangent), 1.0f / s->radius);
    return query;
}

static void search_disks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const disk_job* job = user;
    disk_scan scan;
    scan.search = job->search;
    scan.kernels = job->kernels;
    scan.ranges.count = 0;
    for (size_t i = begin; i < end; ++i) {
        uint32_t surfel = job->search->visit[i];
        assert(scan.ranges.count == 0 && "nothing is left of the previous disk");
        if (i + AHEAD < end) {
            uint32_t next = job->search->visit[i + AHEAD];
            __builtin_prefetch(job->search->positions + 3 * (size_t)next);
            __builtin_prefetch(job->search->normals + 3 * (size_t)next);
            __builtin_prefetch(&job->search->disks[next], 1);
        }
        scan.query = make_query(job->search, surfel);
        scan.disk = (stp_disk){0};
        scan.known_count = 0;
        scan_disk(&scan);
        job->search->disks[surfel] = scan.disk;
    }
}

void stp_disk_search_run(stp_context* context, const stp_disk_search* search)
{
    assert(search->count == 0 || search->radius > 0.0f);
    assert(!(search->footprint < 0.0f));
    assert(search->set_count == 0 || search->set_count <= search->sample_count);
    assert((search->set_count == 0 || search->set_footprint <= search->footprint) &&
           "the search reaches as far as the larger footprint");
    disk_job job = {.search = search, .kernels = stp_near_kernels_select()};
    stp_parallel_for(context, search->count, SURFEL_GRAIN, search_disks, &job);
}
