// SPDX-License-Identifier: MIT
#include "lab/measure/hausdorff.h"

#include <assert.h>

enum {
    GRAIN = 2048,
    EACH_TRIANGLE = 10,
    MIN_SAMPLES = 200000,
    MAX_SAMPLES = 4000000,
    PROOF_SAMPLES = 4, ///< measurements for the proof, per sample
    PROOF_MIN = 65536, ///< additional ones
};

// Fractions of 2^64: the plastic number's inverse and its square.
#define ALONG UINT64_C(0xC13FA9A902A6328F)
#define ACROSS UINT64_C(0x91E10DA5C79E7B1D)

/// Result of one task of a loop.
typedef struct task {
    double max, sum;
    stp_vec3d farthest;
} task;

typedef struct measurement {
    stp_context* context;
    const stp_measured_surface* surface;
    const stp_shape_tree* tree;
    const double* areas;   ///< cumulative triangle areas, and the total
    const float* points;   ///< input of the loop over points or vertices
    const uint8_t* wanted; ///< NULL: all of them
    uint64_t samples;
    task* tasks;
} measurement;

uint64_t stp_hausdorff_samples(size_t triangle_count)
{
    if (triangle_count > MAX_SAMPLES / EACH_TRIANGLE) {
        return MAX_SAMPLES;
    }
    uint64_t samples = EACH_TRIANGLE * (uint64_t)triangle_count;
    return samples > MIN_SAMPLES ? samples : MIN_SAMPLES;
}

static void add_place(task* p, const stp_shape_tree* tree, stp_vec3d place, uint32_t* hint)
{
    double distance = sqrt(stp_shape_tree_distance_squared(tree, place, hint));
    p->sum += distance;
    if (distance > p->max) {
        p->max = distance;
        p->farthest = place;
    }
}

static void measure_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const measurement* m = user;
    task p = {.max = -1.0};
    uint32_t hint = UINT32_MAX;
    for (size_t i = begin; i < end; ++i) {
        if (m->wanted == NULL || m->wanted[i] != 0) {
            const float* at = m->points + 3 * i;
            stp_vec3d place = {(double)at[0], (double)at[1], (double)at[2]};
            add_place(&p, m->tree, place, &hint);
        }
    }
    m->tasks[begin / GRAIN] = p;
    stp_progress_add(m->context, end - begin);
}

static double fraction(uint64_t bits)
{
    return (double)(bits >> 11) * 0x1p-53;
}

static stp_vec3d sample_triangle(const stp_measured_surface* surface, size_t triangle, uint64_t i)
{
    stp_vec3d c[3];
    stp_triangle_corners(surface->positions, surface->indices, triangle, c);
    double u = fraction(i * ALONG), v = fraction(i * ACROSS);
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    assert(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-9 && "within the triangle");
    stp_vec3d offset =
        stp_addd(stp_scaled(stp_subd(c[1], c[0]), u), stp_scaled(stp_subd(c[2], c[0]), v));
    return stp_addd(c[0], offset);
}

// The last triangle with at most `area` of cumulative area before it.
static size_t find_triangle(const measurement* m, double area)
{
    assert(m->surface->triangle_count > 0);
    size_t low = 0, high = m->surface->triangle_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (m->areas[middle] <= area) {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert(!(m->areas[low] > area));
    return low;
}

static void measure_samples(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const measurement* m = user;
    task p = {.max = -1.0};
    uint32_t hint = UINT32_MAX;
    double all = m->areas[m->surface->triangle_count];
    for (size_t i = begin; i < end; ++i) {
        double area = all * (((double)i + 0.5) / (double)m->samples);
        stp_vec3d place = sample_triangle(m->surface, find_triangle(m, area), i + 1);
        add_place(&p, m->tree, place, &hint);
    }
    m->tasks[begin / GRAIN] = p;
    stp_progress_add(m->context, end - begin);
}

static size_t count_tasks(size_t count)
{
    return (count + GRAIN - 1) / GRAIN;
}

// Merges the results of tasks in order.
static stp_result run(measurement* m, size_t count, stp_job job, task* found)
{
    const stp_loop_report report = {.stage = "distances", .unit = "places", .total = count};
    stp_result result = stp_parallel_for_reported(m->context, count, GRAIN, job, m, &report);
    for (size_t i = 0; i < count_tasks(count) && result == STP_OK; ++i) {
        const task* p = &m->tasks[i];
        found->sum += p->sum;
        if (p->max > found->max) {
            found->max = p->max;
            found->farthest = p->farthest;
        }
    }
    return result;
}

static double sum_areas(const stp_measured_surface* surface, double* areas)
{
    double sum = 0.0;
    for (size_t i = 0; i < surface->triangle_count; ++i) {
        stp_vec3d corners[3];
        stp_triangle_corners(surface->positions, surface->indices, i, corners);
        areas[i] = sum;
        sum += stp_triangle_area(corners);
    }
    areas[surface->triangle_count] = sum;
    return sum;
}

static size_t mark_used(const stp_measured_surface* surface, uint8_t* used)
{
    size_t count = 0;
    for (size_t i = 0; i < 3 * surface->triangle_count; ++i) {
        count += used[surface->indices[i]] == 0 ? 1 : 0;
        used[surface->indices[i]] = 1;
    }
    return count;
}

static stp_result measure(measurement* m, stp_hausdorff* hausdorff, double* areas, uint8_t* used)
{
    const stp_measured_surface* s = m->surface;
    hausdorff->area = sum_areas(s, areas);
    size_t vertices = mark_used(s, used);
    task of_points = {.max = -1.0}, of_vertices = of_points, of_samples = of_points;
    m->samples = hausdorff->area > 0.0 && isfinite(hausdorff->area) ? m->samples : 0;
    m->points = s->points;
    stp_result result = run(m, s->point_count, measure_points, &of_points);
    m->points = s->positions;
    m->wanted = used;
    if (result == STP_OK) {
        result = run(m, s->vertex_count, measure_points, &of_vertices);
    }
    if (result == STP_OK && m->samples > 0) {
        result = run(m, (size_t)m->samples, measure_samples, &of_samples);
    }
    const task* all[] = {&of_points, &of_vertices, &of_samples};
    hausdorff->max = -1.0;
    for (int i = 0; i < 3; ++i) {
        if (all[i]->max > hausdorff->max) {
            hausdorff->max = all[i]->max;
            hausdorff->farthest = all[i]->farthest;
        }
    }
    hausdorff->samples = m->samples + s->point_count;
    double sum = of_points.sum + of_samples.sum;
    if (hausdorff->samples == 0) {
        hausdorff->samples = vertices;
        sum = of_vertices.sum;
    }
    assert(hausdorff->samples > 0 && "the surface is not empty");
    hausdorff->mean = sum / (double)hausdorff->samples;
    uint64_t places = PROOF_SAMPLES * m->samples + PROOF_MIN;
    return result == STP_OK ? stp_hausdorff_prove(m->context, s, m->tree, places, hausdorff)
                            : result;
}

static size_t largest_of(size_t a, size_t b)
{
    return a > b ? a : b;
}

stp_result stp_hausdorff_measure(stp_context* context, const stp_measured_surface* surface,
                                 const stp_shape_tree* tree, uint64_t samples,
                                 stp_hausdorff* hausdorff)
{
    *hausdorff = (stp_hausdorff){0};
    if (surface->triangle_count == 0 && surface->point_count == 0) {
        return stp_fail(context, STP_ERROR_ARGUMENT, "distances: the surface to measure is empty");
    }
    if (tree->count == 0) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "distances: no splats or triangles to measure against");
    }
    size_t longest = largest_of(surface->point_count, surface->vertex_count);
    longest = largest_of(longest, (size_t)samples);
    double* areas = STP_NEW_ARRAY(context, double, surface->triangle_count + 1);
    uint8_t* used = STP_NEW_ZEROED(context, uint8_t, surface->vertex_count + 1);
    measurement m = {.context = context,
                     .surface = surface,
                     .tree = tree,
                     .areas = areas,
                     .samples = samples,
                     .tasks = STP_NEW_ARRAY(context, task, count_tasks(longest) + 1)};
    stp_result result = areas != NULL && used != NULL && m.tasks != NULL
                            ? measure(&m, hausdorff, areas, used)
                            : stp_fail_memory(context);
    stp_free(context, areas);
    stp_free(context, used);
    stp_free(context, m.tasks);
    return result;
}

double stp_shapes_area(const stp_shapes* shapes)
{
    double sum = 0.0;
    for (size_t i = 0; i < shapes->disk_count; ++i) {
        sum += stp_disk_area(&shapes->disks[i]);
    }
    for (size_t i = 0; i < shapes->triangle_count; ++i) {
        stp_vec3d corners[3];
        stp_triangle_corners(shapes->positions, shapes->indices, i, corners);
        sum += stp_triangle_area(corners);
    }
    return sum;
}
