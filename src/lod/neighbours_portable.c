// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

static void find_nearest(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t at, float least_agreement,
                         stp_near_findings* found)
{
    for (uint32_t lane = 0; lane < STP_NEAR_LANES; ++lane) {
        float x = samples->x[at + lane], y = samples->y[at + lane], z = samples->z[at + lane];
        float nx = samples->nx[at + lane], ny = samples->ny[at + lane], nz = samples->nz[at + lane];
        uint32_t surfel = found->surfel[lane];
        float least = found->squared[lane];
        for (uint32_t range = 0; range < ranges->count; ++range) {
            for (uint32_t i = ranges->begins[range]; i < ranges->ends[range]; ++i) {
                float dx = x - surfels->x[i], dy = y - surfels->y[i], dz = z - surfels->z[i];
                float squared = dx * dx + dy * dy + dz * dz;
                float agreement = nx * surfels->nx[i] + ny * surfels->ny[i] + nz * surfels->nz[i];
                bool nearer = squared < least || (squared == least && surfels->index[i] < surfel);
                if (nearer && agreement >= least_agreement) {
                    surfel = surfels->index[i];
                    least = squared;
                }
            }
        }
        found->surfel[lane] = surfel;
        found->squared[lane] = least;
    }
}

static stp_disk_hits test_samples(const stp_grid* samples, uint32_t begin, uint32_t end,
                                  const stp_disk_query* query)
{
    stp_disk_hits hits = {0};
    for (uint32_t i = begin; i < end && i < begin + STP_NEAR_LANES; ++i) {
        stp_vec3 offset = {samples->x[i] - query->x, samples->y[i] - query->y,
                           samples->z[i] - query->z};
        float agreement =
            query->nx * samples->nx[i] + query->ny * samples->ny[i] + query->nz * samples->nz[i];
        if (stp_dot(offset, offset) <= query->limit && agreement >= query->least_agreement) {
            bool of_set = samples->index[i] >= query->first_of_sets;
            hits.near |= 1u << (i - begin);
            hits.of_set |= (uint32_t)of_set << (i - begin);
            hits.cells |= stp_stencil_cells(stp_dot(offset, query->tangents[0]),
                                            stp_dot(offset, query->tangents[1]),
                                            of_set ? query->set_footprint : query->footprint);
        }
    }
    return hits;
}

const stp_near_kernels stp_near_kernels_portable = {find_nearest, test_samples};
