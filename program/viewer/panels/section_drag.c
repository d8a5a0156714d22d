// SPDX-License-Identifier: MIT
// Section planes and sides of the section box in the picture: outlines with handles to drag along
// the normal.
#include "program/present/navigate.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>

static const float handle_reach = 11.0f; // pixels at scale 1
static const float arrow_length = 34.0f;
static const uint32_t plane_color = 0xE6A040FF, hovered_color = 0xFFD080FF;

enum { BOX_SIDES = 6 };

/// A draggable object: a section plane, or a side of the section box.
typedef struct drag_target {
    stp_vec3d anchor; ///< position of the handle
    stp_vec3d normal; ///< unit vector
} drag_target;

static bool is_shown(const viewer* v)
{
    return v->shows_panels && v->settings.page == PAGE_SECTION && v->scene != NULL;
}

static stp_vec3d middle_of(const stp_vec3d* corners, int count)
{
    stp_vec3d middle = {0, 0, 0};
    for (int i = 0; i < count; ++i) {
        middle = stp_addd(middle, stp_scaled(corners[i], 1.0 / (double)count));
    }
    return middle;
}

/// Corners of a plane clipped to the scene. @return their number
static int plane_corners(const viewer* v, const section_plane* p, stp_vec3d* corners)
{
    stp_boxd box = camera_scene_box(v);
    stp_vec3d point = stp_addd(p->origin, stp_scaled(p->normal, (double)p->offset));
    return stp_plane_intersect_box(point, p->normal, &box, corners);
}

/// @return false if the target does not exist at the moment
static bool find_target(const viewer* v, int index, drag_target* target)
{
    const section_state* s = &v->section;
    stp_vec3d corners[STP_PLANE_CORNERS_MAX];
    if (index < s->plane_count) {
        const section_plane* p = &s->planes[index];
        int count = p->on ? plane_corners(v, p, corners) : 0;
        *target = (drag_target){count > 0 ? middle_of(corners, count) : p->origin, p->normal};
        return count > 0;
    }
    int side = index - s->plane_count, axis = side / 2;
    stp_vec3d middle = stp_scaled(stp_addd(s->box.min, s->box.max), 0.5);
    stp_vec3d end = side % 2 == 0 ? s->box.max : s->box.min;
    double sign = side % 2 == 0 ? 1.0 : -1.0;
    target->normal = (stp_vec3d){axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
    target->anchor = (stp_vec3d){axis == 0 ? end.x : middle.x, axis == 1 ? end.y : middle.y,
                                 axis == 2 ? end.z : middle.z};
    return s->has_box && side < BOX_SIDES;
}

/// End points of a target's arrow in the window. @return false if it is behind the eye
static bool place_arrow(const viewer* v, const stp_navigator* n, const drag_target* t,
                        float ends[4])
{
    double x, y, depth;
    if (!stp_navigator_project(n, t->anchor, &x, &y, &depth)) {
        return false;
    }
    double length = (double)(arrow_length * v->window.scale) * stp_navigator_pixel(n, depth);
    stp_vec3d tip = stp_addd(t->anchor, stp_scaled(t->normal, length));
    return overlay_place(v, n, t->anchor, &ends[0], &ends[1]) &&
           overlay_place(v, n, tip, &ends[2], &ends[3]);
}

bool section_handle(const viewer* v, int index, float* x, float* y)
{
    stp_navigator n;
    drag_target t;
    float ends[4];
    if (!is_shown(v) || !camera_of_picture(v, &n) || !find_target(v, index, &t) ||
        !place_arrow(v, &n, &t, ends)) {
        return false;
    }
    *x = ends[0];
    *y = ends[1];
    return true;
}

/// The target whose handle or arrow is at a position of the window. @return -1: none
static int find_at(const viewer* v, const stp_navigator* n, float x, float y)
{
    int best = -1;
    float minimum = handle_reach * v->window.scale;
    for (int i = 0; i < v->section.plane_count + BOX_SIDES; ++i) {
        drag_target t;
        float ends[4];
        if (!find_target(v, i, &t) || !place_arrow(v, n, &t, ends)) {
            continue;
        }
        float dx = ends[2] - ends[0], dy = ends[3] - ends[1], square = dx * dx + dy * dy;
        float part = square > 0.0f ? ((x - ends[0]) * dx + (y - ends[1]) * dy) / square : 0.0f;
        part = fminf(fmaxf(part, 0.0f), 1.0f);
        float away = hypotf(x - ends[0] - part * dx, y - ends[1] - part * dy);
        if (away < minimum) {
            minimum = away;
            best = i;
        }
    }
    return best;
}

bool section_grab(viewer* v, float x, float y)
{
    stp_navigator n;
    v->section_grabbed = is_shown(v) && camera_of_picture(v, &n) ? find_at(v, &n, x, y) : -1;
    return v->section_grabbed >= 0;
}

void section_drag(viewer* v, float from_x, float from_y, float to_x, float to_y)
{
    drag_target t;
    section_state* s = &v->section;
    viewer_area a = v->picture_area;
    const double from[2] = {(double)(from_x - a.x), (double)(from_y - a.y)};
    const double to[2] = {(double)(to_x - a.x), (double)(to_y - a.y)};
    if (v->section_grabbed < 0 || !find_target(v, v->section_grabbed, &t)) {
        return;
    }
    double along = stp_plane_drag(&v->camera, t.anchor, t.normal, from, to);
    if (v->section_grabbed < s->plane_count) {
        // limited to the scene, so that the handle stays reachable
        section_plane* p = &s->planes[v->section_grabbed];
        section_plane moved = *p;
        stp_vec3d corners[STP_PLANE_CORNERS_MAX];
        moved.offset += (float)along;
        *p = plane_corners(v, &moved, corners) > 0 ? moved : *p;
        return;
    }
    int side = v->section_grabbed - s->plane_count, axis = side / 2;
    assert(side < BOX_SIDES && "find_target found it");
    double* ends[2][3] = {{&s->box.max.x, &s->box.max.y, &s->box.max.z},
                          {&s->box.min.x, &s->box.min.y, &s->box.min.z}};
    double *end = ends[side % 2][axis], *other = ends[1 - side % 2][axis];
    stp_boxd scene = camera_scene_box(v);
    double sign = side % 2 == 0 ? 1.0 : -1.0, wanted = *end + sign * along;
    double low = axis == 0 ? scene.min.x : axis == 1 ? scene.min.y : scene.min.z;
    double high = axis == 0 ? scene.max.x : axis == 1 ? scene.max.y : scene.max.z;
    wanted = fmin(fmax(wanted, low), high);
    if (sign * (wanted - *other) > 0.001 * (high - low)) {
        *end = wanted;
    }
}

void section_drag_overlay(const viewer* v, const stp_navigator* n)
{
    int ux, uy;
    if (!is_shown(v)) {
        return;
    }
    SDL_GetMouseState(&ux, &uy);
    bool grabs = v->input.drag == DRAG_SECTION;
    int hovered = grabs ? v->section_grabbed
                  : gui_wants_mouse()
                      ? -1
                      : find_at(v, n, (float)ux * v->window.density, (float)uy * v->window.density);
    for (int i = 0; i < v->section.plane_count + BOX_SIDES; ++i) {
        drag_target t;
        float ends[4];
        if (!find_target(v, i, &t) || !place_arrow(v, n, &t, ends)) {
            continue;
        }
        uint32_t color = i == hovered ? hovered_color : plane_color;
        stp_vec3d corners[STP_PLANE_CORNERS_MAX];
        int count =
            i < v->section.plane_count ? plane_corners(v, &v->section.planes[i], corners) : 0;
        for (int k = 0; k < count; ++k) {
            overlay_line(v, n, corners[k], corners[(k + 1) % count], color, 1.5f);
        }
        gui_line(ends[0], ends[1], ends[2], ends[3], color, 2.5f);
        gui_disc(ends[2], ends[3], 3.0f, color, color);
        gui_disc(ends[0], ends[1], 6.0f, color, 0x202020FF);
    }
}
