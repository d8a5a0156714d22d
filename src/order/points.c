// SPDX-License-Identifier: MIT
//
// Bounding box and scale of the points to be ordered. sort_points.c sorts them.
#include "order/points.h"

#include "base/math/math.h"

#include <assert.h>

enum { CHUNK_SIZE = 1 << 16 }; // points measured by one thread at a time

typedef struct bounds_job {
    const float* positions;
    stp_box* boxes; // one per chunk
    bool* finite;
} bounds_job;

static void measure_chunk(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const bounds_job* job = user;
    stp_box box = stp_box_empty();
    float poison = 0.0f; // becomes NaN with the first non-finite coordinate
    for (size_t i = begin; i < end; ++i) {
        const float* p = job->positions + 3 * i;
        stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
        poison += (p[0] * 0.0f + p[1] * 0.0f) + p[2] * 0.0f;
    }
    job->boxes[begin / CHUNK_SIZE] = box;
    job->finite[begin / CHUNK_SIZE] = poison == 0.0f;
}

// The power of two that scales `extent` to [1, 2), as far as single precision allows.
static float unit_scale(double extent)
{
    if (!(extent > 0.0)) {
        return 1.0f;
    }
    int exponent = 0;
    (void)frexp(extent, &exponent); // exact on every machine: only splits the number
    exponent = 1 - exponent;
    exponent = exponent < -126 ? -126 : exponent > 126 ? 126 : exponent;
    return ldexpf(1.0f, exponent);
}

stp_result stp_points_measure(stp_points* points, const stp_team* team)
{
    size_t chunks = ((size_t)points->count + CHUNK_SIZE - 1) / CHUNK_SIZE;
    stp_box* boxes = STP_NEW_ARRAY(team->context, stp_box, chunks);
    bool* finite = STP_NEW_ARRAY(team->context, bool, chunks);
    if (boxes == NULL || finite == NULL) {
        stp_free(team->context, boxes);
        stp_free(team->context, finite);
        return stp_fail_memory(team->context);
    }
    bounds_job job = {points->positions, boxes, finite};
    stp_team_run(team, points->count, CHUNK_SIZE, measure_chunk, &job);
    stp_box box = stp_box_empty();
    bool all_finite = true;
    for (size_t i = 0; i < chunks; ++i) {
        stp_box_add(&box, boxes[i].min);
        stp_box_add(&box, boxes[i].max);
        all_finite = all_finite && finite[i];
    }
    stp_free(team->context, boxes);
    stp_free(team->context, finite);
    if (!all_finite) {
        return stp_fail(team->context, STP_ERROR_ARGUMENT,
                        "order: the positions of points must be finite numbers");
    }
    double x = (double)box.max.x - (double)box.min.x, y = (double)box.max.y - (double)box.min.y,
           z = (double)box.max.z - (double)box.min.z;
    double extent = x > y ? x : y;
    points->box = box;
    points->scale = unit_scale(extent > z ? extent : z);
    assert(points->scale > 0.0f && isfinite(points->scale));
    return STP_OK;
}
