// SPDX-License-Identifier: MIT
#include "lab/measure/distribution.h"

#include "base/core/sort.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    GRAIN = 4096,
    AREA_LEVELS = 10,     // tries grids of 2^1 to 2^10 cells per axis to measure the area
    POINTS_PER_CELL = 16, // least average: then almost every cell with surface has a point
};

typedef struct distance_job {
    const stp_nearest* tree;
    const float* points;
    float* distances;
    bool own; // the points are the tree's own: a point is not its own neighbour
} distance_job;

static void measure_distances(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const distance_job* job = user;
    for (size_t i = begin; i < end; ++i) {
        uint32_t except = job->own ? (uint32_t)i : UINT32_MAX;
        job->distances[i] =
            (float)sqrt(stp_nearest_squared(job->tree, job->points + 3 * i, except));
    }
}

// Sorts non-negative values: their bits sort like integers.
static stp_result sort_values(stp_context* context, float* values, size_t count)
{
    uint64_t* items = STP_NEW_ARRAY(context, uint64_t, 2 * count);
    if (items == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        assert(!(values[i] < 0.0f) && "the sign would be sorted as the highest bit");
        memcpy(&bits, &values[i], sizeof(bits));
        items[i] = bits;
    }
    const uint64_t* sorted = stp_sort_u64(items, items + count, count, 0, 32);
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits = (uint32_t)sorted[i];
        memcpy(&values[i], &bits, sizeof(bits));
    }
    stp_free(context, items);
    return STP_OK;
}

// Quantile of sorted values.
static double quantile(const float* sorted, size_t count, double fraction)
{
    assert(fraction >= 0.0 && fraction <= 1.0);
    return count == 0 ? 0.0 : (double)sorted[(size_t)(fraction * (double)(count - 1) + 0.5)];
}

typedef struct box {
    float low[3], high[3];
} box;

static uint64_t cell_of(const float* p, const box* b, double scale)
{
    uint64_t cell = 0;
    for (int k = 0; k < 3; ++k) {
        cell = cell << 10 | (uint64_t)(((double)p[k] - (double)b->low[k]) * scale);
    }
    return cell;
}

// Estimates the area of the sampled surface from the number of cells it passes through. Averaged
// over directions, a surface of area a intersects 3/2 a / h^2 cells of size h.
static stp_result estimate_area(stp_context* context, const float* points, size_t count,
                                double* area)
{
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            b.low[k] = fminf(b.low[k], points[3 * i + (size_t)k]);
            b.high[k] = fmaxf(b.high[k], points[3 * i + (size_t)k]);
        }
    }
    double extent = 0.0;
    for (int k = 0; k < 3; ++k) {
        double side = count != 0 ? (double)b.high[k] - (double)b.low[k] : 0.0;
        extent = side > extent ? side : extent;
    }
    *area = 0.0;
    if (!(extent > 0.0)) {
        return STP_OK;
    }
    uint64_t* cells = STP_NEW_ARRAY(context, uint64_t, 2 * count);
    if (cells == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t level = 1; level <= AREA_LEVELS; ++level) {
        double across = (double)(1u << level), size = extent / across;
        for (size_t i = 0; i < count; ++i) {
            cells[i] = cell_of(points + 3 * i, &b, across / extent * (1.0 - 1e-9));
        }
        const uint64_t* sorted = stp_sort_u64(cells, cells + count, count, 0, 30);
        size_t occupied = 1;
        for (size_t i = 1; i < count; ++i) {
            occupied += sorted[i] != sorted[i - 1];
        }
        if (level > 1 && count / occupied < POINTS_PER_CELL) {
            break;
        }
        *area = (double)occupied * size * size / 1.5;
    }
    stp_free(context, cells);
    return STP_OK;
}

static stp_result measure_spacings(stp_context* context, const stp_nearest* tree,
                                   const float* ordered, float* spacings, stp_distribution* d)
{
    distance_job job = {tree, ordered, spacings, true};
    stp_parallel_for(context, d->count, GRAIN, measure_distances, &job);
    float* sorted = STP_NEW_ARRAY(context, float, d->count);
    if (sorted == NULL) {
        return stp_fail_memory(context);
    }
    memcpy(sorted, spacings, d->count * sizeof(sorted[0]));
    stp_result result = sort_values(context, sorted, d->count);
    d->spacing_min = quantile(sorted, d->count, 0.0);
    d->spacing_median = quantile(sorted, d->count, 0.5);
    stp_free(context, sorted);
    return result;
}

static stp_result measure_coverage(stp_context* context, const stp_nearest* tree,
                                   const float* points, size_t point_count, stp_distribution* d)
{
    float* distances = STP_NEW_ARRAY(context, float, point_count);
    if (distances == NULL) {
        return stp_fail_memory(context);
    }
    distance_job job = {tree, points, distances, false};
    stp_parallel_for(context, point_count, GRAIN, measure_distances, &job);
    stp_result result = sort_values(context, distances, point_count);
    d->coverage_p50 = quantile(distances, point_count, 0.5);
    d->coverage_p99 = quantile(distances, point_count, 0.99);
    d->coverage_max = quantile(distances, point_count, 1.0);
    size_t uncovered = 0;
    while (uncovered < point_count &&
           (double)distances[point_count - 1 - uncovered] > d->spacing_median) {
        uncovered += 1;
    }
    assert(uncovered <= point_count);
    d->uncovered_fraction = point_count != 0 ? (double)uncovered / (double)point_count : 0.0;
    stp_free(context, distances);
    return result;
}

static stp_result measure(stp_context* context, const stp_nearest* tree, const float* ordered,
                          const float* points, size_t point_count, float* spacings,
                          stp_distribution* d)
{
    float* own = NULL;
    if (spacings == NULL) {
        spacings = own = STP_NEW_ARRAY(context, float, d->count);
        if (own == NULL) {
            return stp_fail_memory(context);
        }
    }
    double area = 0.0;
    stp_result result = measure_spacings(context, tree, ordered, spacings, d);
    if (result == STP_OK) {
        result = measure_coverage(context, tree, points, point_count, d);
    }
    if (result == STP_OK) {
        result = estimate_area(context, points, point_count, &area);
    }
    // no packing of discs is denser than a hexagonal lattice (Lagae and Dutre 2008)
    d->even_spacing = sqrt(2.0 * area / (1.7320508075688772 * (double)d->count));
    d->relative_spacing_min = d->even_spacing > 0.0 ? d->spacing_min / d->even_spacing : 0.0;
    stp_free(context, own);
    return result;
}

stp_result stp_distribution_measure(stp_context* context, const float* ordered, uint32_t count,
                                    const float* points, size_t point_count, float* spacings,
                                    stp_distribution* distribution)
{
    *distribution = (stp_distribution){.count = count};
    if (count == 0) {
        return STP_OK;
    }
    stp_nearest tree;
    stp_result result = stp_nearest_create(context, &tree, ordered, count);
    if (result == STP_OK) {
        result = measure(context, &tree, ordered, points, point_count, spacings, distribution);
        stp_nearest_destroy(context, &tree);
    }
    return result;
}
