// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

#include <assert.h>

static uint32_t find_run(const stp_grid* samples, uint32_t begin, uint32_t end)
{
    assert(begin < end && end <= samples->count);
    int32_t x = stp_grid_cell(samples, samples->x[begin]),
            y = stp_grid_cell(samples, samples->y[begin]),
            z = stp_grid_cell(samples, samples->z[begin]);
    uint32_t run = begin + 1;
    while (run < end && stp_grid_cell(samples, samples->x[run]) == x &&
           stp_grid_cell(samples, samples->y[run]) == y &&
           stp_grid_cell(samples, samples->z[run]) == z) {
        run += 1;
    }
    return run;
}

static void find_nearest(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t begin, uint32_t end, stp_near_rule rule,
                         uint32_t* nearest)
{
    assert(begin <= end && end <= samples->count);
    for (uint32_t at = begin; at < end; ++at) {
        float x = samples->x[at], y = samples->y[at], z = samples->z[at];
        float nx = samples->nx[at], ny = samples->ny[at], nz = samples->nz[at];
        uint32_t surfel = UINT32_MAX;
        float minimum = rule.limit;
        for (uint32_t range = 0; range < ranges->count; ++range) {
            for (uint32_t i = ranges->begins[range]; i < ranges->ends[range]; ++i) {
                float dx = x - surfels->x[i], dy = y - surfels->y[i], dz = z - surfels->z[i];
                float squared = dx * dx + dy * dy + dz * dz;
                float agreement = nx * surfels->nx[i] + ny * surfels->ny[i] + nz * surfels->nz[i];
                bool nearer =
                    squared < minimum || (squared == minimum && surfels->index[i] < surfel);
                if (nearer && agreement >= rule.min_agreement) {
                    surfel = surfels->index[i];
                    minimum = squared;
                }
            }
        }
        nearest[at] = surfel;
    }
}

static bool is_in_disk(const stp_grid* samples, uint32_t at, stp_vec3 offset,
                       const stp_disk_query* query)
{
    float agreement =
        query->nx * samples->nx[at] + query->ny * samples->ny[at] + query->nz * samples->nz[at];
    return stp_dot(offset, offset) <= query->limit && agreement >= query->min_agreement;
}

static bool scan_disk(const stp_grid* samples, const stp_near_ranges* ranges,
                      const stp_disk_query* query, stp_disk* disk)
{
    for (uint32_t range = 0; range < ranges->count; ++range) {
        assert(ranges->ends[range] <= samples->count);
        for (uint32_t i = ranges->begins[range]; i < ranges->ends[range]; ++i) {
            stp_vec3 offset = {samples->x[i] - query->x, samples->y[i] - query->y,
                               samples->z[i] - query->z};
            if (!is_in_disk(samples, i, offset, query)) {
                continue;
            }
            bool of_set = samples->index[i] >= query->first_of_sets;
            disk->count += of_set ? query->set_weight : 1;
            disk->fractions += query->fractions != NULL ? query->fractions[samples->index[i]] : 0;
            uint64_t cells = stp_stencil_cells(stp_dot(offset, query->tangents[0]),
                                               stp_dot(offset, query->tangents[1]),
                                               of_set ? query->set_footprint : query->footprint) &
                             query->stencil->disk;
            if ((cells & ~disk->cells) != 0) {
                disk->cells |= cells;
                disk->full = stp_stencil_is_full(query->stencil, disk->cells);
            }
            if (disk->full && query->until_full) {
                return true;
            }
        }
    }
    return false;
}

static float nearest_squared(const float* x, const float* y, const float* z, uint32_t count,
                             stp_vec3 place)
{
    assert(count % STP_NEAR_LANES == 0 && "other variants read whole vectors");
    float minimum = FLT_MAX;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 offset = {place.x - x[i], place.y - y[i], place.z - z[i]};
        minimum = stp_min(minimum, stp_dot(offset, offset));
    }
    return minimum;
}

const stp_near_kernels stp_near_kernels_portable = {find_run, find_nearest, scan_disk,
                                                    nearest_squared};
