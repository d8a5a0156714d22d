// SPDX-License-Identifier: MIT
#include "capture/covered_pixels.h"

#include "raster/triangles.h"

#include <assert.h>
#include <string.h>

#define ARENA_BLOCK ((size_t)1 << 16)

/// The projection along an axis: the two others are columns and rows.
static stp_raster_matrix project(stp_box box, int axis, double pixel, uint32_t resolution)
{
    const double low[3] = {(double)box.min.x, (double)box.min.y, (double)box.min.z};
    const double high[3] = {(double)box.max.x, (double)box.max.y, (double)box.max.z};
    stp_raster_matrix matrix = {{{0}}};
    int along[2] = {(axis + 1) % 3, (axis + 2) % 3};
    for (int k = 0; k < 2; ++k) {
        int from = along[k];
        double middle = 0.5 * (low[from] + high[from]);
        matrix.m[k][from] = (float)(1.0 / pixel);
        matrix.m[k][3] = (float)(0.5 * (double)resolution - middle / pixel);
    }
    double depth = high[axis] - low[axis], slope = depth > 0.0 ? 0.5 / depth : 0.0;
    matrix.m[2][axis] = (float)slope;
    matrix.m[2][3] = (float)(0.25 - slope * low[axis]);
    matrix.m[3][3] = 1.0f;
    return matrix;
}

/// A mesh to be drawn along each axis.
typedef struct covered_job {
    stp_context* context;
    const stp_raster_mesh* mesh;
    stp_box box;
    double pixel;
    uint32_t width; ///< of the pictures, in pixels
    uint64_t counts[3];
    bool enough[3]; ///< memory
} covered_job;

static void count_along(size_t begin, size_t end, uint32_t worker, void* user)
{
    covered_job* job = user;
    size_t pixels = (size_t)job->width * job->width;
    (void)worker;
    for (size_t axis = begin; axis < end; ++axis) {
        uint64_t* picture = STP_NEW_ARRAY(job->context, uint64_t, pixels);
        if (picture == NULL) {
            continue;
        }
        stp_arena scratch = stp_arena_create(job->context, ARENA_BLOCK);
        const stp_raster_target target = {
            .width = job->width, .height = job->width, .stride = job->width, .pixels = picture};
        stp_raster_matrix matrix = project(job->box, (int)axis, job->pixel, job->width);
        memset(picture, 0xff, pixels * sizeof(*picture));
        job->enough[axis] = stp_raster_triangles(&target, 0, job->width, &matrix, 1.0f, job->mesh,
                                                 0, &scratch) == STP_OK;
        for (size_t i = 0; i < pixels; ++i) {
            job->counts[axis] += picture[i] != STP_RASTER_EMPTY ? 1 : 0;
        }
        stp_arena_destroy(&scratch);
        stp_free(job->context, picture);
    }
}

stp_result stp_count_covered_pixels(stp_context* context, const float* positions,
                                    uint32_t vertex_count, const uint32_t* indices,
                                    uint32_t triangle_count, stp_box box, uint32_t resolution,
                                    uint64_t* count)
{
    assert(resolution >= 1 && resolution <= STP_COVERED_RESOLUTION_MAX);
    stp_vec3 size = stp_sub(box.max, box.min);
    double side = (double)stp_max(size.x, stp_max(size.y, size.z));
    *count = 0;
    if (triangle_count == 0 || !(side > 0.0)) {
        return STP_OK;
    }
    const stp_raster_mesh mesh = {.positions = positions,
                                  .vertex_count = vertex_count,
                                  .indices = indices,
                                  .triangle_count = triangle_count};
    covered_job job = {.context = context,
                       .mesh = &mesh,
                       .box = box,
                       .pixel = side / (double)resolution,
                       .width = resolution + 2}; // a pixel around
    stp_parallel_for(context, 3, 1, count_along, &job);
    *count = job.counts[0] + job.counts[1] + job.counts[2];
    return job.enough[0] && job.enough[1] && job.enough[2] ? STP_OK : stp_fail_memory(context);
}
