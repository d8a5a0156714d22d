// SPDX-License-Identifier: MIT
#include "lod/neighbours_kernels.h"

static stp_near_finding find_nearest(const stp_near_surfels* surfels, const stp_near_query* query,
                                     stp_near_finding found)
{
    for (uint32_t i = 0; i < surfels->count; ++i) {
        float dx = query->x - surfels->x[i], dy = query->y - surfels->y[i],
              dz = query->z - surfels->z[i];
        float squared = dx * dx + dy * dy + dz * dz;
        if (squared <= found.squared) {
            float agreement = query->nx * surfels->nx[i] + query->ny * surfels->ny[i] +
                              query->nz * surfels->nz[i];
            found = agreement >= query->least_agreement
                        ? stp_nearer(found, surfels->index[i], squared)
                        : found;
        }
    }
    return found;
}

static uint32_t test_samples(const stp_grid* samples, uint32_t begin, uint32_t end,
                             const stp_near_query* query)
{
    uint32_t near = 0;
    for (uint32_t i = begin; i < end && i < begin + 8; ++i) {
        float dx = query->x - samples->x[i], dy = query->y - samples->y[i],
              dz = query->z - samples->z[i];
        float squared = dx * dx + dy * dy + dz * dz;
        float agreement =
            query->nx * samples->nx[i] + query->ny * samples->ny[i] + query->nz * samples->nz[i];
        bool hit = squared <= query->limit && agreement >= query->least_agreement;
        near |= (uint32_t)hit << (i - begin);
    }
    return near;
}

const stp_near_kernels stp_near_kernels_portable = {find_nearest, test_samples, 8};
