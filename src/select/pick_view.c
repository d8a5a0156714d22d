// SPDX-License-Identifier: MIT
// Rays of a picture, and snapping.
#include "select/eyes.h"
#include "select/pick_ray.h"
#include "select/view_frame.h"

#include <assert.h>

bool stp_ray_of_pixel(const stp_view* view, double x, double y, stp_ray* ray)
{
    uint32_t eye = 0;
    if (stp_view_eye_count(view) > 1 && x >= (double)(view->width / 2)) {
        eye = 1;
        x -= (double)(view->width / 2);
    }
    stp_view one = stp_view_of_eye(view, eye);
    stp_view_frame frame;
    if (!stp_view_frame_make(&one, &frame)) {
        return false;
    }
    stp_vec3d right = stp_scaled(frame.right, (x - frame.center_x) / frame.scale);
    stp_vec3d beside = stp_addd(right, stp_scaled(frame.down, (y - frame.center_y) / frame.scale));
    stp_vec3d toward = stp_addd(frame.forward, beside);
    double square = stp_dotd(toward, toward);
    if (!isfinite(square)) {
        return false; // the pixel is too far outside
    }
    *ray = (stp_ray){.origin = frame.eye, .direction = frame.forward, .farthest = HUGE_VAL};
    ray->nearest = frame.near_distance;
    if (frame.parallel) {
        ray->origin = stp_addd(frame.eye, beside);
    } else {
        ray->nearest *= sqrt(square); // depths are along the viewing direction
        ray->direction = stp_normalized(toward);
    }
    return isfinite(ray->origin.x) && isfinite(ray->direction.x);
}

void stp_pixel_width(const stp_view* view, double* base, double* slope)
{
    stp_view one = stp_view_of_eye(view, 0);
    stp_view_frame frame;
    *base = *slope = 0.0;
    if (stp_view_frame_make(&one, &frame)) {
        *(frame.parallel ? base : slope) = 1.0 / frame.scale;
    }
}

static stp_vec3d nearest_on_edge(stp_vec3d a, stp_vec3d b, stp_vec3d p)
{
    stp_vec3d along = stp_subd(b, a);
    double square = stp_dotd(along, along);
    double share = square > 0.0 ? stp_dotd(stp_subd(p, a), along) / square : 0.0;
    return stp_addd(a, stp_scaled(along, fmin(fmax(share, 0.0), 1.0)));
}

static double distance_between(stp_vec3d a, stp_vec3d b)
{
    stp_vec3d way = stp_subd(b, a);
    return sqrt(stp_dotd(way, way));
}

stp_snap_kind stp_pick_snap(const stp_pick* pick, double reach, stp_vec3d* position)
{
    *position = pick->position;
    if (!pick->hit) {
        return STP_SNAP_NONE;
    }
    double corner = reach, edge = reach;
    stp_vec3d at_corner = pick->position, at_edge = pick->position;
    bool has_corner = false, has_edge = false;
    for (int k = 0; k < 3; ++k) {
        stp_vec3d a = pick->corners[k], b = pick->corners[(k + 1) % 3];
        stp_vec3d on_edge = nearest_on_edge(a, b, pick->position);
        double to_corner = distance_between(a, pick->position);
        double to_edge = distance_between(on_edge, pick->position);
        if (to_corner <= corner) {
            has_corner = true;
            corner = to_corner;
            at_corner = a;
        }
        if (to_edge <= edge && !pick->inner[k]) {
            has_edge = true;
            edge = to_edge;
            at_edge = on_edge;
        }
    }
    assert((!has_corner || corner <= reach) && (!has_edge || edge <= reach));
    *position = has_corner ? at_corner : has_edge ? at_edge : pick->position;
    return has_corner ? STP_SNAP_VERTEX : has_edge ? STP_SNAP_EDGE : STP_SNAP_NONE;
}
