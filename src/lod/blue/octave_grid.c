// SPDX-License-Identifier: MIT
#include "base/math/math.h"
#include "lod/blue/finish.h"
#include "lod/neighbours_kernels.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

// Number of sampled points: enough to know the median within a few percent.
#define SPACING_SAMPLES 200u
#define SPACING_BATCH 512u // points at a time

void stp_choose_position_grid(stp_boxd box, double min_step, stp_vec3* origin, float* step)
{
    double low[3] = {box.min.x, box.min.y, box.min.z}, high[3] = {box.max.x, box.max.y, box.max.z};
    assert(!(min_step < 0.0));
    double extent = min_step * STP_POSITION_STEPS;
    for (int axis = 0; axis < 3; ++axis) {
        extent = high[axis] - low[axis] > extent ? high[axis] - low[axis] : extent;
    }
    double size = 1.0;
    while (size * STP_POSITION_STEPS >= 2.0 * extent && size > 0x1p-100) {
        size *= 0.5;
    }
    while (size * STP_POSITION_STEPS < extent) {
        size *= 2.0;
    }
    double start[3];
    for (bool fits = false; !fits; size *= fits ? 1.0 : 2.0) {
        fits = true;
        for (int axis = 0; axis < 3; ++axis) {
            // far from zero a float only holds multiples of a larger power of two
            double align = size;
            while (fabs(low[axis]) / align >= 0x1p24 - 1.0) {
                align *= 2.0;
            }
            start[axis] = floor(low[axis] / align) * align;
            fits = fits && floor((high[axis] - start[axis]) / size + 0.5) <= STP_POSITION_STEPS;
        }
    }
    *origin = (stp_vec3){(float)start[0], (float)start[1], (float)start[2]};
    *step = (float)size;
    assert((double)origin->x == start[0] && (double)origin->y == start[1] &&
           (double)origin->z == start[2] && (double)*step == size &&
           "floats hold the grid exactly");
}

uint32_t stp_choose_octaves(const float* envelope, float margin, double area_limit, uint32_t count,
                            uint32_t ends[STP_OCTAVE_LIMIT])
{
    assert(count > 0 && !(margin < 0.0f));
    uint32_t last = count - 1; // the last surfel with a disk
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
        double disk = (double)(envelope[end] + margin);
        bool crowded = STP_PI * disk * disk * (double)end > area_limit;
        if (end < reversed[size - 1] && !crowded) {
            reversed[size++] = end;
        }
        if (end == 1) {
            break;
        }
    }
    for (uint32_t i = 0; i < size; ++i) {
        ends[i] = reversed[size - 1 - i];
        assert((i == 0 || ends[i] > ends[i - 1]) && "octaves ascend");
    }
    assert(ends[size - 1] == count);
    return size;
}

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return x < y ? -1 : x > y;
}

// A block of points as columns, and those of x that a point may be near to.
typedef struct spacing_columns {
    float x[SPACING_BATCH], y[SPACING_BATCH], z[SPACING_BATCH], near_x[SPACING_BATCH];
} spacing_columns;

// Lanes past the end are infinitely far away.
static uint32_t fill_spacing_columns(spacing_columns* to, const float* positions, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        to->x[i] = positions[3 * (size_t)i];
        to->y[i] = positions[3 * (size_t)i + 1];
        to->z[i] = positions[3 * (size_t)i + 2];
    }
    for (; count % STP_NEAR_LANES != 0; ++count) {
        to->x[count] = to->y[count] = to->z[count] = INFINITY;
    }
    assert(count <= SPACING_BATCH && "a batch is a whole number of vectors");
    return count;
}

// Moves points that face apart from a normal infinitely far away. NULL: none.
static void keep_side(spacing_columns* columns, const float* normals, const float* normal,
                      uint32_t count)
{
    memcpy(columns->near_x, columns->x, sizeof(columns->x));
    for (uint32_t i = 0; normals != NULL && i < count; ++i) {
        const float* n = normals + 3 * (size_t)i;
        float cosine = n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2];
        columns->near_x[i] = cosine < 0.0f ? INFINITY : columns->x[i];
    }
}

float stp_median_spacing(const float* positions, const float* normals, uint32_t count)
{
    if (count < 2) {
        return 0.0f;
    }
    const stp_near_kernels* kernels = stp_near_kernels_select();
    uint32_t asked = count < SPACING_SAMPLES ? count : SPACING_SAMPLES;
    float nearest[SPACING_SAMPLES];
    for (uint32_t s = 0; s < asked; ++s) {
        nearest[s] = FLT_MAX;
    }
    spacing_columns columns;
    for (uint32_t begin = 0; begin < count; begin += SPACING_BATCH) {
        uint32_t size = count - begin < SPACING_BATCH ? count - begin : SPACING_BATCH;
        uint32_t filled = fill_spacing_columns(&columns, positions + 3 * (size_t)begin, size);
        const float* sides = normals != NULL ? normals + 3 * (size_t)begin : NULL;
        for (uint32_t s = 0; s < asked; ++s) {
            uint32_t i = (uint32_t)((uint64_t)s * count / asked);
            assert(i < count);
            const float* p = positions + 3 * (size_t)i;
            keep_side(&columns, sides, normals != NULL ? normals + 3 * (size_t)i : NULL, size);
            if (i >= begin && i - begin < size) { // not its own neighbour
                columns.near_x[i - begin] = INFINITY;
            }
            float minimum = kernels->nearest_squared(columns.near_x, columns.y, columns.z, filled,
                                                     (stp_vec3){p[0], p[1], p[2]});
            nearest[s] = stp_min(nearest[s], minimum);
        }
    }
    qsort(nearest, asked, sizeof(float), compare_floats);
    return sqrtf(nearest[asked / 2]);
}
