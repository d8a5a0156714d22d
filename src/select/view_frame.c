// SPDX-License-Identifier: MIT
#include "select/view_frame.h"

static bool finite3(stp_vec3d v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/// The axis least along `v`, for views whose up vector says nothing.
static stp_vec3d other_axis(stp_vec3d v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    if (y <= x && y <= z) {
        return (stp_vec3d){0, 1, 0};
    }
    return z <= x ? (stp_vec3d){0, 0, 1} : (stp_vec3d){1, 0, 0};
}

bool stp_view_frame_make(const stp_view* view, stp_view_frame* frame)
{
    if (view->width == 0 || view->height == 0 || !finite3(view->eye) || !finite3(view->target) ||
        !finite3(view->up)) {
        return false;
    }
    stp_vec3d gaze = stp_subd(view->target, view->eye);
    double distance = sqrt(stp_dotd(gaze, gaze));
    if (!(distance > 0.0) || !isfinite(distance)) {
        return false;
    }
    stp_vec3d forward = stp_scaled(gaze, 1.0 / distance);
    stp_vec3d right = stp_crossd(forward, stp_normalized(view->up));
    if (stp_dotd(right, right) < 1e-12) {
        right = stp_crossd(forward, other_axis(forward));
    }
    right = stp_normalized(right);
    *frame = (stp_view_frame){.eye = view->eye,
                              .right = right,
                              .down = stp_crossd(forward, right),
                              .forward = forward,
                              .center_x = 0.5 * (double)view->width,
                              .center_y = 0.5 * (double)view->height,
                              .width = (double)view->width,
                              .height = (double)view->height};
    if (view->ortho_height > 0.0) {
        frame->parallel = true;
        frame->scale = frame->height / view->ortho_height;
        frame->near_distance = view->near_distance > 0.0 ? view->near_distance : -HUGE_VAL;
    } else {
        if (!(view->fov_degrees > 0.0) || !(view->fov_degrees < 180.0)) {
            return false;
        }
        frame->scale = 0.5 * frame->height / tan(view->fov_degrees * (STP_PI / 360.0));
        frame->near_distance = view->near_distance > 0.0 ? view->near_distance : 1e-4 * distance;
    }
    return isfinite(frame->scale) && frame->scale > 0.0;
}

bool stp_view_frame_is_inside(const stp_view_frame* frame, const stp_boxd* box)
{
    stp_vec3d e = frame->eye;
    return !frame->parallel && e.x >= box->min.x && e.x <= box->max.x && e.y >= box->min.y &&
           e.y <= box->max.y && e.z >= box->min.z && e.z <= box->max.z;
}

/// Least and greatest of axis . (p - eye) + offset . (p - eye) over the box.
static void extent(const stp_view_frame* frame, const stp_boxd* box, stp_vec3d axis, double* low,
                   double* high)
{
    stp_vec3d center = stp_scaled(stp_addd(box->min, box->max), 0.5);
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    double middle = stp_dotd(axis, stp_subd(center, frame->eye));
    double reach = fabs(axis.x) * half.x + fabs(axis.y) * half.y + fabs(axis.z) * half.z;
    *low = middle - reach;
    *high = middle + reach;
}

/// Whether the box is wholly beyond one side of the picture: `side` is the screen axis, `edge` its extent in
/// pixels from the gaze, positive.
static bool beyond(const stp_view_frame* frame, const stp_boxd* box, stp_vec3d side, double edge)
{
    double low, high, slope = edge / frame->scale;
    if (frame->parallel) {
        extent(frame, box, side, &low, &high);
        return low > slope;
    }
    extent(frame, box, stp_subd(side, stp_scaled(frame->forward, slope)), &low, &high);
    return low > 0.0;
}

/// Distance from the eye to the box.
static double distance_to(const stp_view_frame* frame, const stp_boxd* box)
{
    stp_vec3d e = frame->eye;
    double x = fmax(fmax(box->min.x - e.x, e.x - box->max.x), 0.0);
    double y = fmax(fmax(box->min.y - e.y, e.y - box->max.y), 0.0);
    double z = fmax(fmax(box->min.z - e.z, e.z - box->max.z), 0.0);
    return sqrt(x * x + y * y + z * z);
}

bool stp_view_frame_sees(const stp_view_frame* frame, const stp_boxd* box, double* nearest_depth)
{
    double near, far;
    extent(frame, box, frame->forward, &near, &far);
    if (stp_boxd_is_empty(*box) || far < frame->near_distance) {
        return false;
    }
    double margin = 1.0; // a splat's own pixel may stick out of its node's box
    if (beyond(frame, box, frame->right, frame->width - frame->center_x + margin) ||
        beyond(frame, box, stp_scaled(frame->right, -1.0), frame->center_x + margin) ||
        beyond(frame, box, frame->down, frame->height - frame->center_y + margin) ||
        beyond(frame, box, stp_scaled(frame->down, -1.0), frame->center_y + margin)) {
        return false;
    }
    if (!frame->parallel) {
        // what is visible is also no nearer than the box, seen at most from a corner of the picture
        double x = fmax(frame->center_x, frame->width - frame->center_x) / frame->scale;
        double y = fmax(frame->center_y, frame->height - frame->center_y) / frame->scale;
        near = fmax(near, distance_to(frame, box) / sqrt(1.0 + x * x + y * y));
    }
    *nearest_depth = fmax(near, frame->near_distance);
    return true;
}

double stp_view_frame_pixel_size(const stp_view_frame* frame, double depth)
{
    return (frame->parallel ? 1.0 : depth) / frame->scale;
}
