// SPDX-License-Identifier: MIT
#include "select/view_frame.h"

#include "select/sections.h"

#include <assert.h>

static const double max_coordinate = 1e24; // its squares are finite; far beyond any scene

static bool is_within(stp_vec3d v)
{
    return fabs(v.x) <= max_coordinate && fabs(v.y) <= max_coordinate &&
           fabs(v.z) <= max_coordinate;
}

/// The axis least parallel to `v`, for views with a degenerate up vector.
static stp_vec3d other_axis(stp_vec3d v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    if (y <= x && y <= z) {
        return (stp_vec3d){0, 1, 0};
    }
    return z <= x ? (stp_vec3d){0, 0, 1} : (stp_vec3d){1, 0, 0};
}

static void make_sides(stp_view_frame* f)
{
    const double margin = 1.0; // a splat's own pixel may extend beyond its node's box
    const stp_vec3d axes[4] = {f->right, stp_scaled(f->right, -1.0), f->down,
                               stp_scaled(f->down, -1.0)};
    const double edges[4] = {f->width - f->center_x, f->center_x, f->height - f->center_y,
                             f->center_y};
    for (int i = 0; i < 4; ++i) {
        double slope = (edges[i] + margin) / f->scale;
        f->sides[i] = f->parallel ? axes[i] : stp_subd(axes[i], stp_scaled(f->forward, slope));
        f->side_limits[i] = f->parallel ? slope : 0.0;
    }
    double x = fmax(f->center_x, f->width - f->center_x) / f->scale;
    double y = fmax(f->center_y, f->height - f->center_y) / f->scale;
    f->corner = f->parallel ? 1.0 : sqrt(1.0 + x * x + y * y);
}

static const char* find_lens_fault(const stp_view* view)
{
    if (!isfinite(view->near_distance) || view->near_distance < 0.0) {
        return "near_distance must be finite and at least 0";
    }
    if (!(view->eye_distance >= 0.0 && view->eye_distance <= max_coordinate)) {
        return "eye_distance must be from 0 to 1e24";
    }
    if (view->ortho_height != 0.0) {
        bool valid = view->ortho_height > 0.0 && isfinite(view->ortho_height) &&
                     isfinite((double)view->height / view->ortho_height);
        return valid ? NULL : "ortho_height must be finite and above 0, or 0";
    }
    bool valid =
        view->fov_degrees >= STP_FOV_DEGREES_MIN && view->fov_degrees <= STP_FOV_DEGREES_MAX;
    return valid ? NULL : "fov_degrees must be from 0.001 to 179.9";
}

const char* stp_view_find_fault(const stp_view* view)
{
    stp_vec3d gaze = stp_subd(view->target, view->eye);
    double distance = sqrt(stp_dotd(gaze, gaze));
    if (view->width == 0 || view->height == 0) {
        return "width and height must be at least 1";
    }
    if (!is_within(view->eye) || !is_within(view->target)) {
        return "coordinates of eye and target must be numbers of at most 1e24 in size";
    }
    if (!isfinite(view->up.x) || !isfinite(view->up.y) || !isfinite(view->up.z)) {
        return "up must be finite";
    }
    if (!(distance > 0.0)) {
        return "eye and target must differ";
    }
    if (!stp_sections_are_valid(&view->sections)) {
        return "a section is a plane with a normal, and there are at most 14";
    }
    return find_lens_fault(view);
}
_Static_assert(STP_SECTION_PLANES == 14, "the sentence says it");

bool stp_view_frame_make(const stp_view* view, stp_view_frame* frame)
{
    if (stp_view_find_fault(view) != NULL || view->eye_distance != 0.0) {
        return false;
    }
    stp_vec3d gaze = stp_subd(view->target, view->eye);
    double distance = sqrt(stp_dotd(gaze, gaze));
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
        frame->scale = 0.5 * frame->height / tan(view->fov_degrees * (STP_PI / 360.0));
        frame->near_distance = view->near_distance > 0.0 ? view->near_distance : 1e-4 * distance;
    }
    assert(!(fabs(stp_dotd(frame->right, frame->forward)) > 1e-6) &&
           !(fabs(stp_dotd(frame->down, frame->right)) > 1e-6) && "perpendicular axes");
    make_sides(frame);
    return isfinite(frame->scale) && frame->scale > 0.0;
}

bool stp_view_frame_is_inside(const stp_view_frame* frame, const stp_boxd* box)
{
    stp_vec3d e = frame->eye;
    return !frame->parallel && e.x >= box->min.x && e.x <= box->max.x && e.y >= box->min.y &&
           e.y <= box->max.y && e.z >= box->min.z && e.z <= box->max.z;
}

/// Extent of a box with half sides `half` from its centre along an axis.
static double reach_along(stp_vec3d axis, stp_vec3d half)
{
    return fabs(axis.x) * half.x + fabs(axis.y) * half.y + fabs(axis.z) * half.z;
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

bool stp_view_frame_depths(const stp_view_frame* frame, const stp_boxd* box, double* nearest_depth,
                           double* farthest_depth)
{
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    stp_vec3d center = stp_subd(stp_addd(box->min, half), frame->eye);
    double middle = stp_dotd(frame->forward, center), deep = reach_along(frame->forward, half);
    double near = middle - deep, far = middle + deep;
    if (stp_boxd_is_empty(*box) || far < frame->near_distance) {
        return false;
    }
    for (int i = 0; i < 4; ++i) {
        double minimum = stp_dotd(frame->sides[i], center) - reach_along(frame->sides[i], half);
        if (minimum > frame->side_limits[i]) {
            return false;
        }
    }
    if (!frame->parallel) {
        // visible content is also no nearer than the box, seen at most from a corner of the picture
        near = fmax(near, distance_to(frame, box) / frame->corner);
    }
    *nearest_depth = fmax(near, frame->near_distance);
    *farthest_depth = far;
    return true;
}

static void widen(const stp_view_frame* f, stp_view_rectangle* r, double x, double y, double z)
{
    double factor = f->parallel ? f->scale : f->scale / z;
    r->x0 = fmin(r->x0, f->center_x + x * factor);
    r->x1 = fmax(r->x1, f->center_x + x * factor);
    r->y0 = fmin(r->y0, f->center_y + y * factor);
    r->y1 = fmax(r->y1, f->center_y + y * factor);
}

stp_view_rectangle stp_view_frame_cover(const stp_view_frame* f, const stp_boxd* box)
{
    double corners[8][3];
    stp_view_rectangle r = {HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (int i = 0; i < 8; ++i) {
        stp_vec3d p = {(i & 1) != 0 ? box->max.x : box->min.x,
                       (i & 2) != 0 ? box->max.y : box->min.y,
                       (i & 4) != 0 ? box->max.z : box->min.z};
        p = stp_subd(p, f->eye);
        corners[i][0] = stp_dotd(f->right, p);
        corners[i][1] = stp_dotd(f->down, p);
        corners[i][2] = stp_dotd(f->forward, p);
        if (f->parallel || corners[i][2] >= f->near_distance) {
            widen(f, &r, corners[i][0], corners[i][1], corners[i][2]);
        }
    }
    for (int i = 0; i < 8 && !f->parallel; ++i) { // edges that cross the near plane
        for (int k = 1; k < 8; k *= 2) {
            const double *a = corners[i], *b = corners[i | k];
            if ((i & k) == 0 && (a[2] >= f->near_distance) != (b[2] >= f->near_distance)) {
                double part = (f->near_distance - a[2]) / (b[2] - a[2]);
                widen(f, &r, a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]),
                      f->near_distance);
            }
        }
    }
    if (!(r.x0 <= r.x1)) {
        return (stp_view_rectangle){0.0, 0.0, f->width, f->height};
    }
    return (stp_view_rectangle){stp_clampd(r.x0, 0.0, f->width), stp_clampd(r.y0, 0.0, f->height),
                                stp_clampd(r.x1, 0.0, f->width), stp_clampd(r.y1, 0.0, f->height)};
}

const float stp_key_light[3] = {-0.45f, 0.65f, 0.62f};

stp_vec3d stp_view_frame_direction(const stp_view_frame* frame, const float along[3])
{
    stp_vec3d sum = stp_scaled(frame->right, (double)along[0]);
    sum = stp_subd(sum, stp_scaled(frame->down, (double)along[1]));
    return stp_subd(sum, stp_scaled(frame->forward, (double)along[2]));
}

double stp_view_frame_pixel_size(const stp_view_frame* frame, double depth)
{
    return (frame->parallel ? 1.0 : depth) / frame->scale;
}
