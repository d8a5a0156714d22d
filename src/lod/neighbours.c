// SPDX-License-Identifier: MIT
#include "lod/neighbours.h"

#include "base/math.h"
#include "base/processor.h"
#include "lod/neighbours_kernels.h"

#include <string.h>

#define BUCKET_GRAIN 1024
#define SURFEL_GRAIN 512
#define KNOWN_LIMIT 64u

static const stp_near_kernels* choose_kernels(void)
{
#if defined(__x86_64__)
    if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
        return &stp_near_kernels_avx2;
    }
#endif
    return &stp_near_kernels_portable;
}

// The surfels that the samples of one cell may be near to: those of the 2 x 2 x 2 cells around its middle.
typedef struct near_block {
    bool valid;
    int32_t cell[3];
    uint32_t range_count;
    uint32_t begins[8], ends[8];
    bool whole; ///< all surfels of the ranges stand side by side in `surfels`
    stp_near_surfels surfels;
} near_block;

static void copy_range(const stp_grid* grid, uint32_t begin, uint32_t end, stp_near_surfels* to)
{
    for (uint32_t i = begin; i < end; ++i) {
        uint32_t at = to->count++;
        to->index[at] = grid->index[i];
        to->x[at] = grid->x[i];
        to->y[at] = grid->y[i];
        to->z[at] = grid->z[i];
        to->nx[at] = grid->nx[i];
        to->ny[at] = grid->ny[i];
        to->nz[at] = grid->nz[i];
    }
}

static void load_block(const stp_grid* grid, const int32_t cell[3], near_block* block)
{
    memcpy(block->cell, cell, sizeof(block->cell));
    block->valid = true;
    block->range_count = 0;
    uint32_t total = 0;
    for (int corner = 0; corner < 8; ++corner) {
        uint32_t bucket = stp_grid_bucket(grid, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                                          cell[2] + (corner >> 2));
        uint32_t begin = grid->starts[bucket], end = grid->starts[bucket + 1];
        bool known = begin == end;
        for (uint32_t i = 0; !known && i < block->range_count; ++i) {
            known = block->begins[i] == begin;
        }
        if (!known) {
            block->begins[block->range_count] = begin;
            block->ends[block->range_count++] = end;
            total += end - begin;
        }
    }
    block->whole = total <= STP_NEAR_LIMIT;
    block->surfels.count = 0;
    for (uint32_t i = 0; block->whole && i < block->range_count; ++i) {
        copy_range(grid, block->begins[i], block->ends[i], &block->surfels);
    }
}

// The same where the block holds too many surfels to stand side by side: piece after piece.
static stp_near_finding search_pieces(const stp_near_kernels* kernels, const stp_grid* grid,
                                      near_block* block, const stp_near_query* query,
                                      stp_near_finding found)
{
    for (uint32_t i = 0; i < block->range_count; ++i) {
        for (uint32_t at = block->begins[i]; at < block->ends[i]; at += STP_NEAR_LIMIT) {
            uint32_t left = block->ends[i] - at;
            block->surfels.count = 0;
            copy_range(grid, at, at + (left < STP_NEAR_LIMIT ? left : STP_NEAR_LIMIT),
                       &block->surfels);
            found = kernels->find_nearest(&block->surfels, query, found);
        }
    }
    return found;
}

typedef struct nearest_job {
    const stp_nearest_search* search;
    const stp_near_kernels* kernels;
} nearest_job;

static void search_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const nearest_job* job = user;
    const stp_nearest_search* s = job->search;
    const stp_grid* samples = s->samples;
    near_block block;
    memset(&block, 0, sizeof(block));
    stp_near_query query = {.least_agreement = s->two_sided ? -2.0f : 0.0f};
    for (uint32_t at = samples->starts[begin]; at < samples->starts[end]; ++at) {
        query.x = samples->x[at], query.y = samples->y[at], query.z = samples->z[at];
        query.nx = samples->nx[at], query.ny = samples->ny[at], query.nz = samples->nz[at];
        int32_t cell[3] = {stp_grid_cell(samples, query.x), stp_grid_cell(samples, query.y),
                           stp_grid_cell(samples, query.z)};
        if (!block.valid || memcmp(cell, block.cell, sizeof(cell)) != 0) {
            load_block(s->surfels, cell, &block);
        }
        stp_near_finding found = {.surfel = UINT32_MAX, .squared = s->radius * s->radius};
        found = block.whole ? job->kernels->find_nearest(&block.surfels, &query, found)
                            : search_pieces(job->kernels, s->surfels, &block, &query, found);
        s->nearest[at] = found.surfel;
    }
}

void stp_nearest_search_run(stp_context* context, const stp_nearest_search* search)
{
    nearest_job job = {.search = search, .kernels = choose_kernels()};
    stp_parallel_for(context, (size_t)search->samples->mask + 1, BUCKET_GRAIN, search_buckets,
                     &job);
}

// One surfel's disk while it is looked at.
typedef struct disk_scan {
    const stp_disk_search* search;
    const stp_near_kernels* kernels;
    stp_near_query query;
    stp_vec3 tangents[2]; ///< over the radius
    stp_disk disk;
    uint32_t known_count;        ///< buckets looked at
    uint32_t known[KNOWN_LIMIT]; ///< where the last of them begin
} disk_scan;

static void hit_disk(disk_scan* scan, uint32_t at)
{
    const stp_disk_search* s = scan->search;
    stp_vec3 offset = {s->samples->x[at] - scan->query.x, s->samples->y[at] - scan->query.y,
                       s->samples->z[at] - scan->query.z};
    float u = stp_dot(offset, scan->tangents[0]), v = stp_dot(offset, scan->tangents[1]);
    bool of_set = s->set_count != 0 && s->samples->index[at] >= s->sample_count - s->set_count;
    float footprint = of_set ? s->set_footprint : s->footprint;
    uint64_t cells = stp_stencil_cells(u, v, footprint / s->radius) & s->stencil->disk;
    scan->disk.count += of_set ? s->set_weight : 1;
    scan->disk.fractions += s->fractions != NULL ? s->fractions[s->samples->index[at]] : 0;
    if ((cells & ~scan->disk.cells) != 0) {
        scan->disk.cells |= cells;
        scan->disk.solid = stp_stencil_is_solid(s->stencil, scan->disk.cells);
    }
}

// Cells may share a bucket; each is to be looked at once.
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

// @return whether the disk needs no further look
static bool scan_cell(disk_scan* scan, int32_t x, int32_t y, int32_t z)
{
    const stp_grid* samples = scan->search->samples;
    uint32_t bucket = stp_grid_bucket(samples, x, y, z);
    uint32_t begin = samples->starts[bucket], end = samples->starts[bucket + 1];
    if (begin == end || is_known(scan, begin)) {
        return false;
    }
    for (uint32_t at = begin; at < end; at += scan->kernels->lanes) {
        uint32_t near = scan->kernels->test_samples(samples, at, end, &scan->query);
        for (; near != 0; near &= near - 1) {
            hit_disk(scan, at + (uint32_t)__builtin_ctz(near));
            if (scan->disk.solid && scan->search->until_solid) {
                return true;
            }
        }
    }
    return false;
}

static void scan_cells(disk_scan* scan)
{
    const stp_grid* samples = scan->search->samples;
    float reach = scan->search->radius + scan->search->footprint;
    float place[3] = {scan->query.x, scan->query.y, scan->query.z};
    int32_t low[3], high[3], middle[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = stp_grid_cell(samples, place[axis] - reach);
        high[axis] = stp_grid_cell(samples, place[axis] + reach);
        middle[axis] = stp_grid_cell(samples, place[axis]);
    }
    bool done =
        scan_cell(scan, middle[0], middle[1], middle[2]); // most disks are solid, and show it here
    for (int32_t z = low[2]; !done && z <= high[2]; ++z) {
        for (int32_t y = low[1]; !done && y <= high[1]; ++y) {
            for (int32_t x = low[0]; !done && x <= high[0]; ++x) {
                bool first = x == middle[0] && y == middle[1] && z == middle[2];
                done = !first && scan_cell(scan, x, y, z);
            }
        }
    }
}

typedef struct disk_job {
    const stp_disk_search* search;
    const stp_near_kernels* kernels;
} disk_job;

static void search_disks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const disk_job* job = user;
    const stp_disk_search* s = job->search;
    float limit = s->radius + s->footprint;
    for (size_t i = begin; i < end; ++i) {
        uint32_t surfel = s->visit[i];
        const float* p = s->positions + 3 * (size_t)surfel;
        const float* n = s->normals + 3 * (size_t)surfel;
        disk_scan scan;
        scan.search = s;
        scan.kernels = job->kernels;
        scan.disk = (stp_disk){0};
        scan.known_count = 0;
        scan.query = (stp_near_query){p[0], p[1], p[2], n[0], n[1], n[2], limit * limit, 0.0f};
        scan.query.least_agreement = s->two_sided ? -2.0f : 0.0f;
        float x = fabsf(n[0]), y = fabsf(n[1]), z = fabsf(n[2]);
        stp_vec3 normal = {n[0], n[1], n[2]};
        stp_vec3 axis = {x <= y && x <= z, y < x && y <= z, z < x && z < y};
        stp_vec3 tangent = stp_normalize(stp_cross(normal, axis));
        scan.tangents[0] = stp_scale(tangent, 1.0f / s->radius);
        scan.tangents[1] = stp_scale(stp_cross(normal, tangent), 1.0f / s->radius);
        scan_cells(&scan);
        s->disks[surfel] = scan.disk;
    }
}

void stp_disk_search_run(stp_context* context, const stp_disk_search* search)
{
    disk_job job = {.search = search, .kernels = choose_kernels()};
    stp_parallel_for(context, search->count, SURFEL_GRAIN, search_disks, &job);
}
