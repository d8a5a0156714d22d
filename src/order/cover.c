// SPDX-License-Identifier: MIT
#include "base/math/math.h"
#include "order/order_kinds.h"

#include <assert.h>

enum { GRAIN = 1 << 14, BATCH = 256 };

stp_result stp_cover_create_grid(const stp_points* points, stp_context* context,
                                 stp_near_grid* grid)
{
    stp_vec3 low = stp_scale(points->box.min, points->scale);
    stp_vec3 size = stp_sub(stp_scale(points->box.max, points->scale), low);
    return stp_near_grid_create(context, grid, (float[3]){low.x, low.y, low.z},
                                stp_max(stp_max(size.x, size.y), size.z));
}

typedef struct cover_job {
    const stp_points* points;
    const stp_near_grid* grid;
    stp_near_grid_nearest nearest;
    float* farthest; // squared, per task
} cover_job;

static void cover_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const cover_job* job = user;
    float positions[3 * BATCH], squared[BATCH], maximum = 0.0f;
    for (size_t batch = begin; batch < end; batch += BATCH) {
        uint32_t count = (uint32_t)(end - batch < BATCH ? end - batch : BATCH);
        for (uint32_t i = 0; i < count; ++i) {
            stp_vec3 p = stp_points_scaled(job->points, (uint32_t)batch + i);
            positions[3 * i] = p.x;
            positions[3 * i + 1] = p.y;
            positions[3 * i + 2] = p.z;
        }
        job->nearest(job->grid, positions, count, squared);
        for (uint32_t i = 0; i < count; ++i) {
            maximum = stp_max(maximum, squared[i]);
        }
    }
    job->farthest[begin / GRAIN] = maximum;
}

stp_result stp_cover_radius(const stp_points* points, const stp_team* team,
                            const stp_near_grid* grid, float* radius)
{
    assert(points->scale > 0.0f && grid->point_count > 0 && "a chosen point");
    size_t tasks = ((size_t)points->count + GRAIN - 1) / GRAIN;
    float* farthest = STP_NEW_ARRAY(team->context, float, tasks);
    if (farthest == NULL) {
        return stp_fail_memory(team->context);
    }
    cover_job job = {points, grid, stp_near_grid_nearest_select(), farthest};
    stp_team_run(team, points->count, GRAIN, cover_task, &job);
    float maximum = 0.0f;
    for (size_t i = 0; i < tasks; ++i) {
        maximum = stp_max(maximum, farthest[i]);
    }
    stp_free(team->context, farthest);
    *radius = sqrtf(maximum) / points->scale;
    return STP_OK;
}
