// SPDX-License-Identifier: MIT
// Parallel projections from all sides, at one scale.
#include "capture/capture_internal.h"

#include <assert.h>

/// Unit vectors across the direction of view.
static void view_axes(stp_vec3d toward, stp_vec3d* right, stp_vec3d* down)
{
    assert(fabs(stp_dotd(toward, toward) - 1.0) < 1e-3);
    stp_vec3d up = fabs(toward.y) > 0.95 ? (stp_vec3d){0.0, 0.0, -1.0} : (stp_vec3d){0.0, 1.0, 0.0};
    *right = stp_normalized(stp_crossd(up, toward));
    *down = stp_crossd(*right, toward);
}

static double extent_along(const stp_capture_job* job, stp_vec3d axis)
{
    stp_vec3d h = job->half_extent;
    return 2.0 * (fabs(axis.x) * h.x + fabs(axis.y) * h.y + fabs(axis.z) * h.z);
}

double stp_capture_widest(const stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                          double* area)
{
    double widest = 0.0;
    *area = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d right, down;
        view_axes(directions[i], &right, &down);
        double width = extent_along(job, right), height = extent_along(job, down);
        widest = width > widest ? width : widest;
        widest = height > widest ? height : widest;
        *area += width * height;
    }
    return widest;
}

void stp_capture_set_views(stp_capture_job* job, const stp_vec3d* directions, uint32_t count,
                           double pixel_size)
{
    assert(pixel_size > 0.0);
    double reach = sqrt(stp_dotd(job->half_extent, job->half_extent));
    reach = reach > 0.0 ? reach : 1.0;
    job->view_count = count;
    for (uint32_t i = 0; i < count; ++i) {
        stp_capture_view* view = &job->views[i];
        stp_vec3d right, down;
        view_axes(directions[i], &right, &down);
        // one extra pixel on each side, for rounding
        assert(!(extent_along(job, right) / pixel_size >= 65536.0));
        assert(!(extent_along(job, down) / pixel_size >= 65536.0) && "pixels are 32-bit numbers");
        view->width = (uint32_t)(extent_along(job, right) / pixel_size) + 3;
        view->height = (uint32_t)(extent_along(job, down) / pixel_size) + 3;
        view->shift_x = (double)view->width * 0.5;
        view->shift_y = (double)view->height * 0.5;
        view->silhouette = NULL;
        view->toward = directions[i];
        view->right = stp_scaled(right, 1.0 / pixel_size);
        view->down = stp_scaled(down, 1.0 / pixel_size);
        view->depth = stp_scaled(directions[i], 0.4 / reach);
    }
}
