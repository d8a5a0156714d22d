// SPDX-License-Identifier: MIT
// The view cube and the scale bar in the corners of the picture.
#include "program/present/navigate.h"
#include "program/present/view_cube.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>

static const float half_edge = 23.0f; // half the cube's edge, pixels at scale 1
static const float margin = 14.0f;    // to the picture's edge
static const float bar_max = 160.0f;  // maximum width of the scale bar

static const uint32_t face_color = 0xF4F5F7F0;
static const uint32_t face_hovered = 0xA8D4F0F8;
static const uint32_t handle_color = 0xF4F5F7B0;
static const uint32_t edge_color = 0x50565EFF;
static const uint32_t letter_color = 0x2A2E33FF;
static const uint32_t bar_color = 0x24282DFF;
static const uint32_t bar_rim = 0xFFFFFFB0;

/// Axes of the scene in their usual colours; in a z-up file, colours follow its axis names.
static uint32_t axis_color(const viewer* v, int axis)
{
    static const uint32_t colors[3] = {0xD65C5CFF, 0x5FA34AFF, 0x4C82D8FF};
    return colors[section_file_axis(v, axis)];
}

static bool is_shown(const viewer* v)
{
    viewer_area a = v->picture_area;
    float scale = v->window.scale;
    return v->shows_panels && v->settings.guides && v->scene != NULL &&
           !stp_boxd_is_empty(v->scene->bounds) && a.width > 260.0f * scale &&
           a.height > 180.0f * scale;
}

/// The cube's centre in the window.
static void cube_center(const viewer* v, float* x, float* y)
{
    viewer_area a = v->picture_area;
    float reach = ((float)STP_VIEW_CUBE_REACH * half_edge + margin) * v->window.scale;
    *x = a.x + a.width - reach;
    *y = a.y + reach;
}

/// The side of the cube at a position of the window. @return -1 if there is none
static int find_side(const viewer* v, const stp_view_cube* cube, float x, float y)
{
    float cx, cy, unit = half_edge * v->window.scale;
    cube_center(v, &cx, &cy);
    return stp_view_cube_hit(cube, (double)((x - cx) / unit), (double)((y - cy) / unit));
}

/// The side of the view cube (program/present/view_cube.h) at a position of the window; -1: none.
static int side_at(const viewer* v, float x, float y)
{
    stp_navigator n;
    if (!is_shown(v) || !camera_of_picture(v, &n)) {
        return -1;
    }
    stp_navigator_axes axes = stp_navigator_get_axes(&n);
    stp_view_cube cube;
    stp_view_cube_make(&axes, &cube);
    return find_side(v, &cube, x, y);
}

const char* orientation_place(const viewer* v, int side, float* x, float* y)
{
    stp_navigator n;
    assert(side >= 0 && side < STP_VIEW_CUBE_SIDES);
    if (!is_shown(v) || !camera_of_picture(v, &n)) {
        return NULL;
    }
    float cx, cy, unit = half_edge * v->window.scale;
    stp_navigator_axes axes = stp_navigator_get_axes(&n);
    stp_view_cube cube;
    stp_view_cube_make(&axes, &cube);
    cube_center(v, &cx, &cy);
    const stp_view_cube_side* s = &cube.sides[side];
    const double* places[2] = {s->handle, s->center};
    for (int i = 0; i < 2; ++i) {
        if (stp_view_cube_hit(&cube, places[i][0], places[i][1]) == side) {
            *x = cx + (float)places[i][0] * unit;
            *y = cy + (float)places[i][1] * unit;
            return s->view;
        }
    }
    return NULL;
}

bool orientation_click(viewer* v, float x, float y)
{
    int side = side_at(v, x, y);
    if (side >= 0) {
        stp_navigator_axes axes = stp_navigator_get_axes(&v->camera);
        stp_view_cube cube;
        stp_view_cube_make(&axes, &cube);
        camera_face(v, stp_view_cube_target(&cube, side));
    }
    return side >= 0;
}

static const char* side_label(const stp_view_cube_side* s)
{
    static const char* const labels[3][2] = {
        {"Left", "Right"}, {"Bottom", "Top"}, {"Back", "Front"}};
    return labels[s->axis][s->positive];
}

static void show_face(const viewer* v, const stp_view_cube_side* s, float cx, float cy,
                      bool hovered)
{
    float unit = half_edge * v->window.scale, corners[8];
    for (int k = 0; k < 4; ++k) {
        corners[2 * k] = cx + (float)s->corners[k][0] * unit;
        corners[2 * k + 1] = cy + (float)s->corners[k][1] * unit;
    }
    gui_polygon(corners, 4, hovered ? face_hovered : face_color, edge_color);
    if (s->facing > 0.5) {
        gui_letters(cx + (float)s->center[0] * unit, cy + (float)s->center[1] * unit, 0.75f,
                    side_label(s), letter_color);
    }
}

/// Draws the handles before or behind the faces; positive axes have the file's axis names.
static void show_handles(const viewer* v, const stp_view_cube* cube, bool in_front, int hovered)
{
    static const char* const letters[] = {"X", "Y", "Z"};
    float cx, cy, unit = half_edge * v->window.scale;
    bool z_up = v->scene->directory->up == 'z';
    cube_center(v, &cx, &cy);
    for (int i = 0; i < STP_VIEW_CUBE_SIDES; ++i) {
        const stp_view_cube_side* s = &cube->sides[i];
        if (!s->has_handle || (s->facing > 0.0) != in_front) {
            continue;
        }
        bool turned = z_up && s->axis == 2; // the file's y points backwards
        bool named = s->positive != turned;
        uint32_t color = axis_color(v, s->axis);
        float x = cx + (float)s->handle[0] * unit, y = cy + (float)s->handle[1] * unit;
        float from = named ? 0.55f : 0.78f; // the line starts at the cube's side
        if (named || !in_front) {
            gui_line(cx + from * (x - cx), cy + from * (y - cy), x, y, color, named ? 2.5f : 1.0f);
        }
        gui_disc(x, y, (float)STP_VIEW_CUBE_HANDLE * half_edge,
                 i == hovered ? face_hovered
                 : named      ? color
                              : handle_color,
                 color);
        if (named) {
            gui_letters(x, y, 0.8f, letters[section_file_axis(v, s->axis)],
                        i == hovered ? letter_color : 0xFFFFFFFF);
        }
    }
}

static void show_cube(const viewer* v, const stp_navigator* n)
{
    float cx, cy;
    int ux, uy;
    stp_navigator_axes axes = stp_navigator_get_axes(n);
    stp_view_cube cube;
    stp_view_cube_make(&axes, &cube);
    cube_center(v, &cx, &cy);
    SDL_GetMouseState(&ux, &uy);
    int hovered =
        gui_wants_mouse() || v->input.button != 0
            ? -1
            : find_side(v, &cube, (float)ux * v->window.density, (float)uy * v->window.density);
    show_handles(v, &cube, false, hovered);
    for (int i = 0; i < STP_VIEW_CUBE_SIDES; ++i) {
        if (cube.sides[i].visible) {
            show_face(v, &cube.sides[i], cx, cy, i == hovered);
        }
    }
    show_handles(v, &cube, true, hovered);
}

/// Size of a pixel for which the scale bar is exact: everywhere in parallel projection, else at the
/// pivot's depth.
static double scale_pixel(const viewer* v, const stp_navigator* n)
{
    double x, y, depth = n->reach;
    bool before = stp_navigator_project(n, v->camera.pivot, &x, &y, &depth);
    double pixel = stp_navigator_pixel(n, before ? depth : n->reach);
    return v->picture_area.width > 0.0f ? pixel * (double)n->width / (double)v->picture_area.width
                                        : 0.0;
}

stp_scale_bar orientation_scale_bar(const viewer* v, const stp_navigator* n)
{
    stp_measuring m = measure_units(v);
    double factor = stp_measure_factor(&m);
    float maximum = fminf(bar_max * v->window.scale, 0.4f * v->picture_area.width);
    return is_shown(v) ? stp_scale_bar_make(scale_pixel(v, n) * factor, (double)maximum)
                       : (stp_scale_bar){0};
}

static void show_scale_bar(const viewer* v, const stp_navigator* n)
{
    stp_scale_bar bar = orientation_scale_bar(v, n);
    viewer_area a = v->picture_area;
    float scale = v->window.scale, tick = 5.0f * scale;
    if (!(bar.pixels > 0.0)) {
        return;
    }
    stp_measuring m = measure_units(v);
    char text[64];
    stp_measure_text(&m, bar.length / stp_measure_factor(&m), 6, text, sizeof(text));
    float x0 = a.x + a.width - margin * scale - (float)bar.pixels;
    float x1 = x0 + (float)bar.pixels, y = a.y + a.height - margin * scale;
    for (int pass = 0; pass < 2; ++pass) { // a light outline for dark backgrounds
        uint32_t color = pass == 0 ? bar_rim : bar_color;
        float width = pass == 0 ? 4.5f : 2.0f;
        gui_line(x0, y, x1, y, color, width);
        gui_line(x0, y - tick, x0, y + 0.5f * scale, color, width);
        gui_line(x1, y - tick, x1, y + 0.5f * scale, color, width);
    }
    gui_plate(0.5f * (x0 + x1), y - 15.0f * scale, text, 0xE6E8EBFF);
}

void orientation_overlay(const viewer* v, const stp_navigator* n)
{
    if (is_shown(v)) {
        show_cube(v, n);
        show_scale_bar(v, n);
    }
}
