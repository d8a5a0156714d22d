// SPDX-License-Identifier: MIT
#include "select/eyes.h"

#include "select/view_frame.h"

#include <assert.h>

stp_view stp_view_of_eye(const stp_view* view, uint32_t eye)
{
    stp_view one = *view;
    stp_view_frame frame;
    assert(eye < stp_view_eye_count(view));
    if (stp_view_eye_count(view) == 1) {
        return one;
    }
    one.eye_distance = 0.0;
    one.width /= 2;
    if (stp_view_frame_make(&one, &frame)) { // otherwise its user rejects it
        double side = eye == 0 ? -0.5 : 0.5;
        stp_vec3d shift = stp_scaled(frame.right, side * view->eye_distance);
        one.eye = stp_addd(view->eye, shift);
        one.target = stp_addd(view->target, shift);
    }
    return one;
}

stp_result stp_view_check(stp_context* context, const stp_view* view)
{
    const char* fault = stp_view_find_fault(view);
    stp_view_frame frame;
    for (uint32_t i = 0; fault == NULL && i < stp_view_eye_count(view); ++i) {
        stp_view one = stp_view_of_eye(view, i);
        fault = stp_view_frame_make(&one, &frame)
                    ? NULL
                    : "two eyes need two pixels side by side, and a smaller eye_distance";
    }
    return fault == NULL ? STP_OK : stp_fail(context, STP_ERROR_ARGUMENT, "view: %s", fault);
}

bool stp_fovea_is_valid(const stp_fovea* f)
{
    bool valid = f->count <= STP_FOVEA_ZONES && isfinite(f->center[0]) && isfinite(f->center[1]);
    for (uint32_t i = 0; valid && i < f->count; ++i) {
        stp_fovea_zone zone = f->zones[i];
        valid = isfinite(zone.radius) && isfinite(zone.factor) && zone.factor > 0.0f &&
                zone.radius >= 0.0f && (i == 0 || zone.radius > f->zones[i - 1].radius);
    }
    return valid;
}

bool stp_fovea_is_same(const stp_fovea* a, const stp_fovea* b)
{
    bool same =
        a->count == b->count && a->center[0] == b->center[0] && a->center[1] == b->center[1];
    for (uint32_t i = 0; same && i < a->count; ++i) {
        same = a->zones[i].radius == b->zones[i].radius && a->zones[i].factor == b->zones[i].factor;
    }
    return same;
}

/// The factor at a distance from the gaze point, in half diagonals.
static double factor_at(const stp_fovea* f, double radius)
{
    double from = 0.0, factor = 1.0;
    assert(!(radius < 0.0) && f->count <= STP_FOVEA_ZONES);
    for (uint32_t i = 0; i < f->count; ++i) {
        double to = (double)f->zones[i].radius, next = (double)f->zones[i].factor;
        if (radius < to) {
            return factor + (next - factor) * (radius - from) / (to - from);
        }
        from = to;
        factor = next;
    }
    return factor;
}

void stp_fovea_bound(const stp_fovea* f, const stp_view_frame* frame,
                     const stp_view_rectangle* rectangle, double* minimum, double* greatest)
{
    assert(rectangle->x0 <= rectangle->x1 && rectangle->y0 <= rectangle->y1);
    double half = 0.5 * sqrt(frame->width * frame->width + frame->height * frame->height);
    double x = 0.5 * frame->width + (double)f->center[0] * half;
    double y = 0.5 * frame->height + (double)f->center[1] * half;
    double x0 = rectangle->x0 - x, x1 = rectangle->x1 - x;
    double y0 = rectangle->y0 - y, y1 = rectangle->y1 - y;
    double dx = fmax(fmax(x0, -x1), 0.0), dy = fmax(fmax(y0, -y1), 0.0);
    double nearest = sqrt(dx * dx + dy * dy) / half;
    dx = fmax(-x0, x1);
    dy = fmax(-y0, y1);
    double farthest = sqrt(dx * dx + dy * dy) / half;
    double a = factor_at(f, nearest), b = factor_at(f, farthest);
    *minimum = fmin(a, b);
    *greatest = fmax(a, b);
    for (uint32_t i = 0; i < f->count; ++i) {
        double radius = (double)f->zones[i].radius, factor = (double)f->zones[i].factor;
        if (radius >= nearest && radius <= farthest) {
            *minimum = fmin(*minimum, factor);
            *greatest = fmax(*greatest, factor);
        }
    }
}
