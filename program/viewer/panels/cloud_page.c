// SPDX-License-Identifier: MIT
// Settings of point clouds: default eye-dome lighting, and point size.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

float cloud_page_eye_dome(const viewer* v)
{
    float chosen = v->settings.drawing.style.eye_dome;
    if (chosen >= 0.0f) {
        return chosen;
    }
    return v->scene != NULL ? cloud_style_eye_dome(v->scene->store) : 0.0f;
}

static bool has_points(const viewer* v)
{
    return v->scene != NULL && v->scene->directory->point_set_count > 0;
}

void cloud_page_give(const viewer* v, paint_request* request)
{
    const viewer_settings* s = &v->settings;
    stp_point_sizing sizing = s->drawing.style.point_sizing;
    bool in_metres = sizing == STP_POINTS_UNITS;
    cloud_point_size size = {.in_metres = in_metres};
    request->style.point_sizing = STP_POINTS_ADAPTIVE;
    if (!has_points(v)) {
        return;
    }
    if (sizing == STP_POINTS_ADAPTIVE) {
        request->style.splat_scale = s->point_scale != 1.0f ? s->point_scale : 0.0f;
        return;
    }
    size.width = (double)(in_metres ? s->point_metres : s->point_pixels);
    cloud_style_set_size(&size, v->scene->store, &request->style);
    request->quality.points_apart = true;
    if (request->quality.method == 0) { // its splats are points
        request->quality.method = STP_METHOD_BLUE;
    }
}

void cloud_page_show(viewer* v)
{
    static const char* const sizings[] = {"Adaptive", "Pixels", "Metres"};
    viewer_settings* s = &v->settings;
    if (!has_points(v)) {
        return;
    }
    int sizing = (int)s->drawing.style.point_sizing;
    gui_choice("Points", &sizing, sizings, 3,
               "Adaptive: points are large enough to close the gaps between them. Pixels, "
               "Metres: all points have the same size");
    s->drawing.style.point_sizing = (stp_point_sizing)sizing;
    if (sizing == STP_POINTS_ADAPTIVE) {
        gui_log_slider("Point size", &s->point_scale, 0.25f, 4.0f, "%.2f x",
                       "Relative to the size that closes the gaps between points");
    } else if (sizing == STP_POINTS_PIXELS) {
        gui_log_slider("Point size", &s->point_pixels, 1.0f, 32.0f, "%.1f px",
                       "Width of each point on the screen");
    } else {
        gui_log_slider("Point size", &s->point_metres, 0.001f, 10.0f, "%.3f m",
                       "Width of each point in the scene, in metres, or in scene units if the "
                       "unit is not known");
    }
}
