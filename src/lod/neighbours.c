// SPDX-License-Identifier: MIT
#include "lod/neighbours.h"

#include "lod/stencil.h"

#define GRAIN 8192

// What one sample found so far.
typedef struct finding {
    uint32_t surfel;
    float squared;
} finding;

static void hit_disk(const stp_neighbour_walk* walk, uint32_t sample, uint32_t surfel,
                     const float offset[3])
{
    const float* t = walk->frames + 6 * (size_t)surfel;
    float scale = 1.0f / walk->disk_radius;
    float u = (offset[0] * t[0] + offset[1] * t[1] + offset[2] * t[2]) * scale;
    float v = (offset[0] * t[3] + offset[1] * t[4] + offset[2] * t[5]) * scale;
    uint64_t cells = stp_stencil_cells(u, v, walk->footprint * scale);
    // setting bits and adding whole numbers give the same result in any order; a full disk stays full
    _Atomic uint64_t* disk = &walk->disks[surfel];
    uint64_t known = atomic_load_explicit(disk, memory_order_relaxed) & walk->disk_cells;
    if (known == walk->disk_cells) {
        return;
    }
    if ((cells & walk->disk_cells & ~known) != 0) {
        atomic_fetch_or_explicit(disk, cells, memory_order_relaxed);
    }
    if (walk->sums != NULL) {
        uint64_t fraction = walk->fractions != NULL ? walk->fractions[sample] : 0;
        atomic_fetch_add_explicit(&walk->sums[surfel], ((uint64_t)1 << STP_SUM_SHIFT) + fraction,
                                  memory_order_relaxed);
    }
}

// Looks at the surfels of one page of a block.
static void scan_page(const stp_neighbour_walk* walk, const stp_grid_block* block, uint32_t sample,
                      finding* found)
{
    const float* p = walk->positions + 3 * (size_t)sample;
    const float* n = walk->normals + 3 * (size_t)sample;
    float px = p[0], py = p[1], pz = p[2], nx = n[0], ny = n[1], nz = n[2];
    float limit = walk->disk_radius + walk->footprint;
    limit = walk->frames != NULL ? limit * limit : -1.0f;
    float least_agreement = walk->two_sided ? -2.0f : 0.0f;
    float squared[STP_GRID_PAGE], agreement[STP_GRID_PAGE];
    uint32_t count = block->count;
    for (uint32_t i = 0; i < count; ++i) {
        float dx = px - block->x[i], dy = py - block->y[i], dz = pz - block->z[i];
        squared[i] = dx * dx + dy * dy + dz * dz;
        agreement[i] = nx * block->nx[i] + ny * block->ny[i] + nz * block->nz[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        if (agreement[i] < least_agreement) {
            continue;
        }
        uint32_t surfel = block->index[i];
        bool nearer =
            squared[i] < found->squared || (squared[i] == found->squared && surfel < found->surfel);
        if (nearer) {
            *found = (finding){.surfel = surfel, .squared = squared[i]};
        }
        if (squared[i] <= limit) {
            float offset[3] = {px - block->x[i], py - block->y[i], pz - block->z[i]};
            hit_disk(walk, sample, surfel, offset);
        }
    }
}

static void walk_samples(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const stp_neighbour_walk* walk = user;
    stp_grid_block block;
    block.valid = false;
    float reach = walk->nearest_radius;
    for (size_t i = begin; i < end; ++i) {
        uint32_t sample = (uint32_t)(i * walk->stride);
        finding found = {.surfel = UINT32_MAX, .squared = reach * reach};
        bool more = stp_grid_load(walk->grid, &block, walk->positions + 3 * (size_t)sample);
        scan_page(walk, &block, sample, &found);
        while (more) {
            more = stp_grid_next(walk->grid, &block);
            scan_page(walk, &block, sample, &found);
        }
        if (walk->nearest != NULL) {
            walk->nearest[sample] = found.surfel;
        }
    }
}

void stp_neighbour_walk_run(stp_context* context, const stp_neighbour_walk* walk)
{
    size_t steps = ((size_t)walk->count + walk->stride - 1) / walk->stride;
    stp_neighbour_walk copy = *walk;
    stp_parallel_for(context, steps, GRAIN, walk_samples, &copy);
}
