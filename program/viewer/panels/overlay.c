// SPDX-License-Identifier: MIT
// The picture and its overlays: pivot, selection, sections, measurements, notes. All of them use
// the camera of the shown picture, so that they stay in place while the next one is drawn.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>

enum { CHOSEN_COLOR = 0x4DB3F2FF };

bool overlay_place(const viewer* v, const stp_navigator* n, stp_vec3d point, float* x, float* y)
{
    viewer_area a = v->picture_area;
    double px, py, depth;
    assert(n->width > 0 && n->height > 0);
    bool before = stp_navigator_project(n, point, &px, &py, &depth);
    *x = a.x + (float)(px / (double)n->width) * a.width;
    *y = a.y + (float)(py / (double)n->height) * a.height;
    return before;
}

void overlay_line(const viewer* v, const stp_navigator* n, stp_vec3d a, stp_vec3d b, uint32_t color,
                  float width)
{
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    double minimum = 1e-4 * n->reach; // clips everything behind the eye
    double da = -stp_dotd(axes.back, stp_subd(a, n->eye));
    double db = -stp_dotd(axes.back, stp_subd(b, n->eye));
    if (!(n->ortho_height > 0.0)) {
        if (da < minimum && db < minimum) {
            return;
        }
        stp_vec3d way = stp_subd(b, a);
        if (da < minimum) {
            a = stp_addd(a, stp_scaled(way, (minimum - da) / (db - da)));
        } else if (db < minimum) {
            b = stp_addd(a, stp_scaled(way, (minimum - da) / (db - da)));
        }
    }
    float x0, y0, x1, y1;
    (void)overlay_place(v, n, a, &x0, &y0);
    (void)overlay_place(v, n, b, &x1, &y1);
    gui_line(x0, y0, x1, y1, color, width);
}

void overlay_box(const viewer* v, const stp_navigator* n, const stp_boxd* box, uint32_t color,
                 float width)
{
    stp_vec3d corners[8];
    for (int i = 0; i < 8; ++i) {
        corners[i] = (stp_vec3d){(i & 1) != 0 ? box->max.x : box->min.x,
                                 (i & 2) != 0 ? box->max.y : box->min.y,
                                 (i & 4) != 0 ? box->max.z : box->min.z};
    }
    for (int i = 0; i < 8; ++i) {
        for (int k = 1; k < 8; k *= 2) {
            if ((i & k) == 0) {
                overlay_line(v, n, corners[i], corners[i | k], color, width);
            }
        }
    }
}

static void show_pivot(const viewer* v, const stp_navigator* n)
{
    float x, y;
    bool turns = v->input.drag == DRAG_ORBIT;
    if ((turns || v->camera.pivot_chosen) && overlay_place(v, n, v->camera.pivot, &x, &y)) {
        gui_disc(x, y, turns ? 5.0f : 3.5f, turns ? 0x4D9ED1FF : 0x4D9ED1A0, 0xFFFFFFC0);
    }
}

void overlay_show(viewer* v)
{
    stp_navigator n;
    stp_boxd box;
    viewer_area a = v->picture_area;
    void* picture = window_picture(&v->window);
    if (picture == NULL || !camera_of_picture(v, &n)) {
        return;
    }
    gui_picture(picture, a.x, a.y, a.x + a.width, a.y + a.height);
    gui_clip(a.x, a.y, a.x + a.width, a.y + a.height);
    selection_overlay(v);
    if (v->explorer != NULL && explorer_chosen_box(v->explorer, &box)) {
        overlay_box(v, &n, &box, CHOSEN_COLOR, 1.5f);
    }
    section_overlay(v, &n);
    measure_overlay(v, &n);
    views_overlay(v, &n);
    show_pivot(v, &n);
    orientation_overlay(v, &n);
    point_style_overlay(v);
    messages_overlay(v);
    gui_unclip();
}
