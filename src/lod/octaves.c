// SPDX-License-Identifier: MIT
#include "base/math.h"
#include "lod/finish.h"

#include <stdlib.h>

#define GRID_STEPS 65535.0
#define SPACING_SAMPLES                                                                            \
    200u // points whose neighbour is looked for: the median of so many is known within a few percent

void stp_choose_position_grid(stp_boxd box, double least_step, stp_vec3* origin, float* step)
{
    double low[3] = {box.min.x, box.min.y, box.min.z}, high[3] = {box.max.x, box.max.y, box.max.z};
    double extent = least_step * GRID_STEPS;
    for (int axis = 0; axis < 3; ++axis) {
        extent = high[axis] - low[axis] > extent ? high[axis] - low[axis] : extent;
    }
    double size = 1.0;
    while (size * GRID_STEPS >= 2.0 * extent && size > 0x1p-100) {
        size *= 0.5;
    }
    while (size * GRID_STEPS < extent) {
        size *= 2.0;
    }
    double start[3];
    for (bool fits = false; !fits; size *= fits ? 1.0 : 2.0) {
        fits = true;
        for (int axis = 0; axis < 3; ++axis) {
            double align =
                size; // far from zero a float only holds multiples of a larger power of two
            while (fabs(low[axis]) / align >= 0x1p24 - 1.0) {
                align *= 2.0;
            }
            start[axis] = floor(low[axis] / align) * align;
            fits = fits && floor((high[axis] - start[axis]) / size + 0.5) <= GRID_STEPS;
        }
    }
    *origin = (stp_vec3){(float)start[0], (float)start[1], (float)start[2]};
    *step = (float)size;
}

uint32_t stp_choose_octaves(const float* envelope, float margin, uint32_t count,
                            uint32_t ends[STP_OCTAVE_LIMIT])
{
    uint32_t last = count - 1; // the last surfel whose disk is larger than none
    while (last > 0 && !(envelope[last] + margin > 0.0f)) {
        last -= 1;
    }
    uint32_t reversed[STP_OCTAVE_LIMIT], size = 0;
    reversed[size++] = count;
    uint32_t end = last;
    for (double radius = 2.0 * (double)(envelope[last] + margin);
         last > 0 && size < STP_OCTAVE_LIMIT; radius *= 2.0) {
        while (end > 0 && (double)(envelope[end - 1] + margin) < radius) {
            end -= 1;
        }
        if (end == 0 || isinf(envelope[end])) {
            break;
        }
        if (end < reversed[size - 1]) {
            reversed[size++] = end;
        }
        if (end == 1) {
            break;
        }
    }
    for (uint32_t i = 0; i < size; ++i) {
        ends[i] = reversed[size - 1 - i];
    }
    return size;
}

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return x < y ? -1 : x > y;
}

float stp_median_spacing(const float* positions, uint32_t count, float* scratch)
{
    if (count < 2) {
        return 0.0f;
    }
    uint32_t asked = count < SPACING_SAMPLES ? count : SPACING_SAMPLES;
    for (uint32_t s = 0; s < asked; ++s) {
        uint32_t i = (uint32_t)((uint64_t)s * count / asked);
        const float* p = positions + 3 * (size_t)i;
        float nearest = FLT_MAX;
        for (uint32_t k = 0; k < count; ++k) {
            const float* q = positions + 3 * (size_t)k;
            float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
            float squared = x * x + y * y + z * z;
            nearest = k != i && squared < nearest ? squared : nearest;
        }
        scratch[s] = nearest;
    }
    qsort(scratch, asked, sizeof(float), compare_floats);
    return sqrtf(scratch[asked / 2]);
}
