// SPDX-License-Identifier: MIT
#include "program/present/navigate.h"

#include "select/camera.h"

#include <assert.h>
#include <math.h>

static const double quarter = 0.5 * STP_PI;
static const double reaches_per_second = 0.6; // flight speed
static const double seeing_seconds = 0.35;    // time to adapt to most of a new distance
static const double speed_step = 1.25, speed_min = 0.01, speed_max = 100.0;
static const double alike = 3.0; // depths within this factor count as similar

static double slope_of(const stp_navigator* n)
{
    return tan(n->fov_degrees * (STP_PI / 360.0));
}

static void clamp_reach(stp_navigator* n)
{
    assert(n->min_reach > 0.0 && n->min_reach <= n->max_reach && "initialised");
    n->reach = stp_clampd(n->reach, n->min_reach, n->max_reach);
}

stp_navigator_axes stp_navigator_get_axes(const stp_navigator* n)
{
    double sa = sin(n->azimuth), ca = cos(n->azimuth);
    double se = sin(n->elevation), ce = cos(n->elevation);
    double sr = sin(n->roll), cr = cos(n->roll);
    stp_vec3d right = {ca, 0.0, -sa}, up = {-se * sa, ce, -se * ca};
    return (stp_navigator_axes){
        .right = stp_subd(stp_scaled(right, cr), stp_scaled(up, sr)),
        .up = stp_addd(stp_scaled(up, cr), stp_scaled(right, sr)),
        .back = {ce * sa, se, ce * ca},
    };
}

static stp_vec3d along(const stp_navigator_axes* axes, stp_vec3d v)
{
    return (stp_vec3d){stp_dotd(axes->right, v), stp_dotd(axes->up, v), stp_dotd(axes->back, v)};
}

static stp_vec3d across(const stp_navigator_axes* axes, stp_vec3d v)
{
    return stp_addd(stp_addd(stp_scaled(axes->right, v.x), stp_scaled(axes->up, v.y)),
                    stp_scaled(axes->back, v.z));
}

void stp_navigator_init(stp_navigator* n, const stp_boxd* scene, uint32_t width, uint32_t height)
{
    stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd box = stp_boxd_is_empty(*scene) ? unit : *scene;
    double size = stp_lengthd(stp_subd(box.max, box.min));
    size = size > 0.0 ? size : 1.0;
    *n = (stp_navigator){.fov_degrees = STP_CAMERA_FOV,
                         .speed = 1.0,
                         .min_reach = 1e-7 * size,
                         .max_reach = 1e3 * size,
                         .reach = size,
                         .width = width > 0 ? width : 1,
                         .height = height > 0 ? height : 1};
    (void)stp_navigator_face(n, "iso", &box, NULL);
}

void stp_navigator_read_view(stp_navigator* n, const stp_view* view)
{
    stp_vec3d gaze = stp_subd(view->eye, view->target), back = stp_normalized(gaze);
    n->eye = view->eye;
    n->elevation = asin(stp_clampd(back.y, -1.0, 1.0));
    double flat = sqrt(back.x * back.x + back.z * back.z);
    bool upright = flat < 1e-9; // then the picture's up gives the azimuth
    double side = back.y > 0.0 ? -1.0 : 1.0;
    n->azimuth = upright ? atan2(side * view->up.x, side * view->up.z) : atan2(back.x, back.z);
    n->roll = 0.0;
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double x = stp_dotd(view->up, axes.right), y = stp_dotd(view->up, axes.up);
    n->roll = fabs(x) > 1e-9 * fabs(y) ? atan2(x, y) : y < 0.0 ? STP_PI : 0.0;
    n->fov_degrees = view->fov_degrees > 0.0 ? view->fov_degrees : n->fov_degrees;
    n->ortho_height = view->ortho_height;
    n->reach = stp_lengthd(gaze);
    n->pivot = view->target;
    n->pivot_chosen = false;
    clamp_reach(n);
}

void stp_navigator_write_view(const stp_navigator* n, stp_view* view)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    view->eye = n->eye;
    view->target = stp_subd(n->eye, stp_scaled(axes.back, n->reach));
    view->up = axes.up;
    view->fov_degrees = n->fov_degrees;
    view->ortho_height = n->ortho_height;
    view->width = n->width;
    view->height = n->height;
}

double stp_navigator_pixel(const stp_navigator* n, double depth)
{
    return n->ortho_height > 0.0 ? n->ortho_height / (double)n->height
                                 : 2.0 * slope_of(n) * depth / (double)n->height;
}

stp_vec3d stp_navigator_point(const stp_navigator* n, double x, double y, double depth)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double pixel = stp_navigator_pixel(n, depth);
    stp_vec3d offset = {(x - 0.5 * (double)n->width) * pixel, (0.5 * (double)n->height - y) * pixel,
                        -depth};
    return stp_addd(n->eye, across(&axes, offset));
}

bool stp_navigator_project(const stp_navigator* n, stp_vec3d point, double* x, double* y,
                           double* depth)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    stp_vec3d p = along(&axes, stp_subd(point, n->eye));
    *depth = -p.z;
    bool before = n->ortho_height > 0.0 || *depth > 0.0;
    double pixel = stp_navigator_pixel(n, before ? *depth : 1.0);
    *x = 0.5 * (double)n->width + p.x / pixel;
    *y = 0.5 * (double)n->height - p.y / pixel;
    return before;
}

void stp_navigator_orbit_by(stp_navigator* n, double right, double down, double clockwise)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    stp_vec3d offset = along(&axes, stp_subd(n->eye, n->pivot));
    stp_navigator_turn(n, right, down);
    n->roll = remainder(n->roll - clockwise, 2.0 * STP_PI);
    axes = stp_navigator_get_axes(n);
    n->eye = stp_addd(n->pivot, across(&axes, offset));
}

void stp_navigator_orbit(stp_navigator* n, double dx, double dy)
{
    double angle = STP_PI / (double)n->height;
    stp_navigator_orbit_by(n, dx * angle, dy * angle, 0.0);
}

void stp_navigator_begin_orbit(stp_navigator* n, const stp_vec3d* seen)
{
    double x, y, depth, seen_depth;
    bool before = stp_navigator_project(n, n->pivot, &x, &y, &depth);
    bool shown = before && x >= 0.0 && y >= 0.0 && x <= (double)n->width && y <= (double)n->height;
    if (n->pivot_chosen && shown) {
        return;
    }
    n->pivot_chosen = false;
    if (seen != NULL) {
        double sx, sy;
        (void)stp_navigator_project(n, *seen, &sx, &sy, &seen_depth);
        if (!shown || (!(n->ortho_height > 0.0) &&
                       (depth > alike * seen_depth || seen_depth > alike * depth))) {
            n->pivot = *seen;
        }
    } else if (!shown) {
        n->pivot =
            stp_navigator_point(n, 0.5 * (double)n->width, 0.5 * (double)n->height, n->reach);
    }
}

void stp_navigator_choose_pivot(stp_navigator* n, stp_vec3d pivot)
{
    n->pivot = pivot;
    n->pivot_chosen = true;
}

void stp_navigator_turn(stp_navigator* n, double right, double down)
{
    n->azimuth = remainder(n->azimuth - right, 2.0 * STP_PI);
    n->elevation = stp_clampd(n->elevation + down, -quarter, quarter);
}

// A pivot that was not chosen moves with the view.
static void move(stp_navigator* n, stp_vec3d by)
{
    n->eye = stp_addd(n->eye, by);
    n->pivot = n->pivot_chosen ? n->pivot : stp_addd(n->pivot, by);
}

void stp_navigator_pan(stp_navigator* n, double dx, double dy, double depth)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double pixel = stp_navigator_pixel(n, depth);
    move(n, across(&axes, (stp_vec3d){-dx * pixel, dy * pixel, 0.0}));
}

void stp_navigator_zoom(stp_navigator* n, stp_vec3d point, double factor)
{
    stp_vec3d offset = stp_subd(n->eye, point);
    if (n->ortho_height > 0.0) {
        double height = stp_clampd(n->ortho_height * factor, n->min_reach, n->max_reach);
        factor = height / n->ortho_height;
        n->ortho_height = height;
        // only sideways; the eye's distance matters only when switching back to perspective
        stp_navigator_axes axes = stp_navigator_get_axes(n);
        stp_vec3d o = along(&axes, offset);
        n->eye = stp_addd(point, across(&axes, (stp_vec3d){o.x * factor, o.y * factor, o.z}));
        n->reach *= factor;
    } else {
        double distance = stp_lengthd(offset);
        double wanted = stp_clampd(distance * factor, n->min_reach, fmax(n->max_reach, distance));
        factor = distance > 0.0 ? wanted / distance : 1.0;
        n->eye = stp_addd(point, stp_scaled(offset, factor));
        n->reach *= factor;
    }
    clamp_reach(n);
}

void stp_navigator_fly(stp_navigator* n, const double moves[3], double seconds, double faster)
{
    double step = reaches_per_second * n->speed * faster * n->reach * seconds;
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    stp_vec3d by = stp_scaled(axes.right, moves[0] * step);
    by.y += moves[1] * step;
    if (n->ortho_height > 0.0) { // forward enlarges
        double height = n->ortho_height * exp(-moves[2] * step / n->reach);
        n->ortho_height = stp_clampd(height, n->min_reach, n->max_reach);
    } else {
        by = stp_subd(by, stp_scaled(axes.back, moves[2] * step));
    }
    move(n, by);
}

void stp_navigator_adapt_speed(stp_navigator* n, double distance, double seconds)
{
    if (distance > 0.0 && isfinite(distance)) {
        double wanted = stp_clampd(distance, n->min_reach, n->max_reach);
        double part = 1.0 - exp(-seconds / seeing_seconds);
        n->reach *= pow(wanted / n->reach, part);
        clamp_reach(n);
    }
}

void stp_navigator_change_speed(stp_navigator* n, double steps)
{
    n->speed = stp_clampd(n->speed * pow(speed_step, steps), speed_min, speed_max);
}

/// The view of the camera, to be fitted.
static stp_view unfitted_view(const stp_navigator* n, const stp_sections* sections)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    stp_view view = {.eye = axes.back,
                     .up = axes.up,
                     .width = n->width,
                     .height = n->height,
                     .fov_degrees = n->fov_degrees,
                     .ortho_height = n->ortho_height};
    view.sections = sections != NULL ? *sections : view.sections;
    return view;
}

static void take_fitted(stp_navigator* n, const stp_view* view, stp_vec3d pivot)
{
    double distance = stp_lengthd(stp_subd(view->eye, view->target));
    if (n->ortho_height > 0.0) {
        n->ortho_height = stp_clampd(view->ortho_height, n->min_reach, n->max_reach);
        distance = 0.5 * n->ortho_height / slope_of(n);
    }
    distance = stp_clampd(distance, n->min_reach, n->max_reach);
    n->eye = stp_addd(view->target, stp_scaled(stp_navigator_get_axes(n).back, distance));
    n->reach = distance;
    n->pivot = pivot;
    n->pivot_chosen = false;
}

void stp_navigator_frame(stp_navigator* n, const stp_boxd* box, const stp_sections* sections)
{
    if (stp_boxd_is_empty(*box)) {
        return;
    }
    stp_view view = unfitted_view(n, sections);
    stp_camera_fit(&view, box);
    take_fitted(n, &view, stp_scaled(stp_addd(box->min, box->max), 0.5));
}

void stp_navigator_frame_content(stp_navigator* n, const stp_farthest_store* content,
                                 const stp_placed_node* placed, stp_vec3d pivot,
                                 const stp_sections* sections)
{
    stp_view view = unfitted_view(n, sections);
    stp_camera_fit_store(content, placed, &view);
    take_fitted(n, &view, pivot);
}

bool stp_navigator_turn_to(stp_navigator* n, const char* name)
{
    stp_view view = {.fov_degrees = n->fov_degrees};
    if (!stp_camera_face(name, &view)) {
        return false;
    }
    stp_navigator facing = *n;
    stp_navigator_read_view(&facing, &view);
    n->azimuth = facing.azimuth;
    n->elevation = facing.elevation;
    n->roll = facing.roll;
    return true;
}

bool stp_navigator_face(stp_navigator* n, const char* name, const stp_boxd* box,
                        const stp_sections* sections)
{
    stp_boxd unit = {{-1, -1, -1}, {1, 1, 1}};
    if (!stp_navigator_turn_to(n, name)) {
        return false;
    }
    stp_navigator_frame(n, stp_boxd_is_empty(*box) ? &unit : box, sections);
    return true;
}

void stp_navigator_switch_projection(stp_navigator* n)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double x, y, depth;
    if (n->ortho_height > 0.0) {
        // the distance from the pivot that keeps its size
        (void)stp_navigator_project(n, n->pivot, &x, &y, &depth);
        double wanted = 0.5 * n->ortho_height / slope_of(n);
        n->eye = stp_addd(n->eye, stp_scaled(axes.back, wanted - depth));
        n->ortho_height = 0.0;
        n->reach = wanted;
    } else {
        bool before = stp_navigator_project(n, n->pivot, &x, &y, &depth);
        depth = before && depth > n->min_reach ? depth : n->reach;
        n->ortho_height = 2.0 * slope_of(n) * depth;
        n->reach = depth;
    }
    clamp_reach(n);
}

static double between(double a, double b, double part)
{
    return a + (b - a) * part;
}

static double between_angles(double a, double b, double part)
{
    return a + remainder(b - a, 2.0 * STP_PI) * part;
}

static double between_sizes(double a, double b, double part)
{
    return a > 0.0 && b > 0.0 ? a * pow(b / a, part) : b;
}

stp_navigator stp_navigator_mix(const stp_navigator* from, const stp_navigator* to, double part)
{
    if (part >= 1.0) {
        return *to;
    }
    stp_navigator n = *to;
    n.azimuth = between_angles(from->azimuth, to->azimuth, part);
    n.elevation = between(from->elevation, to->elevation, part);
    n.roll = between_angles(from->roll, to->roll, part);
    n.ortho_height = between_sizes(from->ortho_height, to->ortho_height, part);
    n.fov_degrees = between(from->fov_degrees, to->fov_degrees, part);
    n.reach = between_sizes(from->reach, to->reach, part);
    // the target moves linearly; distance and direction determine the eye
    stp_navigator_axes a = stp_navigator_get_axes(from), b = stp_navigator_get_axes(to);
    stp_navigator_axes axes = stp_navigator_get_axes(&n);
    stp_vec3d start = stp_subd(from->eye, stp_scaled(a.back, from->reach));
    stp_vec3d end = stp_subd(to->eye, stp_scaled(b.back, to->reach));
    stp_vec3d target = stp_addd(start, stp_scaled(stp_subd(end, start), part));
    n.eye = stp_addd(target, stp_scaled(axes.back, n.reach));
    return n;
}

stp_scale_bar stp_scale_bar_make(double pixel, double max_pixels)
{
    static const double steps[] = {5.0, 2.0, 1.0};
    double maximum = pixel * max_pixels;
    if (!(pixel > 0.0) || !(max_pixels > 0.0) || !isfinite(maximum) || !(maximum > 1e-300)) {
        return (stp_scale_bar){0};
    }
    double power = pow(10.0, floor(log10(maximum)));
    for (int i = 0; i < 3; ++i) {
        double length = steps[i] * power;
        // log10 may be off by one rounding: the tenth of the power is the last resort
        if (length <= maximum) {
            return (stp_scale_bar){length, length / pixel};
        }
    }
    assert(0.5 * power <= maximum && "the bar fits");
    return (stp_scale_bar){0.5 * power, 0.5 * power / pixel};
}
