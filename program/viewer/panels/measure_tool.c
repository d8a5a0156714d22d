// SPDX-License-Identifier: MIT
// Measuring: clicked points, and distances, angles and areas between them, in the display unit and
// along the file's axes.
#include "embed/measuring.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"
#include "store/file/point_attributes.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const uint32_t line_color = 0xFFD24DFF;
static const double snap_pixels = 9.0;

stp_measuring measure_units(const viewer* v)
{
    static const double metres[UNIT_COUNT] = {0.0, 0.001, 0.01, 1.0, 0.0254, 0.3048};
    stp_measuring m = {.up = 'y', .shown_metres = metres[v->settings.unit]};
    if (v->scene != NULL) {
        m.unit_metres = v->scene->directory->unit_metres;
        m.up = v->scene->directory->up;
    }
    return m;
}

void measure_print(const viewer* v, double length, char* text, size_t size)
{
    stp_measuring m = measure_units(v);
    stp_measure_text(&m, length, 6, text, size);
}

/// Whether the file's coordinates are east, north and height.
static bool is_surveyed(const viewer* v)
{
    return v->explorer != NULL && v->scene != NULL && v->scene->directory->up == 'z' &&
           stp_store_coordinate_system(v->explorer->store) != NULL;
}

/// Prints coordinates along the file's axes, with prefixes.
static void print_coordinates(const viewer* v, const stp_measuring* m, stp_vec3d point,
                              const char* const names[3], char* text, size_t size)
{
    stp_vec3d p = stp_measure_coordinates(m, point);
    stp_boxd box = camera_scene_box(v);
    stp_vec3d sides = stp_subd(box.max, box.min);
    double factor = stp_measure_factor(m), reach = factor * sqrt(stp_dotd(sides, sides));
    double digits = reach > 0.0 && isfinite(reach) ? 6.0 - floor(log10(reach)) : 3.0;
    int decimals = digits < 0.0 ? 0 : digits > 9.0 ? 9 : (int)digits;
    snprintf(text, size, "%s%.*f, %s%.*f, %s%.*f", names[0], decimals, factor * p.x, names[1],
             decimals, factor * p.y, names[2], decimals, factor * p.z);
}

void measure_print_point(const viewer* v, stp_vec3d point, char* text, size_t size)
{
    static const char* const axes[3] = {"", "", ""};
    static const char* const directions[3] = {"E ", "N ", "H "};
    stp_measuring m = measure_units(v);
    bool surveyed = is_surveyed(v);
    m.shown_metres = surveyed ? 0.0 : m.shown_metres; // a coordinate system has its own unit
    print_coordinates(v, &m, point, surveyed ? directions : axes, text, size);
    size_t used = strlen(text);
    snprintf(text + used, size - used, " %s", stp_measure_unit(&m));
}

void measure_copy(viewer* v, stp_vec3d point)
{
    static const char* const none[3] = {"", "", ""};
    stp_measuring m = measure_units(v);
    char text[128];
    m.shown_metres = 0.0;
    print_coordinates(v, &m, point, none, text, sizeof(text));
    if (SDL_SetClipboardText(text) == 0) {
        viewer_show_message(v, false, "Copied %s", text);
    } else {
        viewer_show_message(v, true, "The coordinates cannot be copied: %s", SDL_GetError());
    }
}

void measure_click(viewer* v, const stp_pick* pick, const stp_vec3d* seen)
{
    if (v->measure.count == MEASURE_POINTS || (pick == NULL && seen == NULL)) {
        return;
    }
    stp_vec3d point = pick != NULL ? pick->position : *seen;
    if (pick != NULL && pick->part.kind == STP_STORE_PART_MESH && v->measure.snaps) {
        double base, slope;
        stp_pixel_width(&v->picture->view, &base, &slope);
        (void)stp_pick_snap(pick, snap_pixels * (base + slope * pick->distance), &point);
    }
    v->measure.points[v->measure.count++] = point;
}

void measure_undo(viewer* v)
{
    v->measure.count -= v->measure.count > 0 ? 1 : 0;
}

static void show_length(const viewer* v, const char* name, double length)
{
    char text[64];
    measure_print(v, length, text, sizeof(text));
    gui_value(name, "%s", text);
}

static void show_results(const viewer* v)
{
    const measure_state* m = &v->measure;
    int last = m->count - 1;
    assert(last > 0 && "a distance has two points");
    double total = 0.0;
    for (int i = 0; i < last; ++i) {
        total += stp_measure_distance(m->points[i], m->points[i + 1]).length;
    }
    stp_distance d = stp_measure_distance(m->points[last - 1], m->points[last]);
    show_length(v, "Distance", d.length);
    show_length(v, "Horizontal", d.horizontal);
    show_length(v, "Height", d.height);
    gui_value("Slope", "%.3f\u00b0", d.slope);
    if (m->count > 2) {
        gui_separator();
        show_length(v, "Total", total);
        gui_value("Angle", "%.3f\u00b0",
                  stp_measure_angle(m->points[last - 2], m->points[last - 1], m->points[last]));
        double around, area = stp_measure_area(m->points, (size_t)m->count, &around);
        stp_measuring unit = measure_units(v);
        double factor = stp_measure_factor(&unit);
        gui_value("Area", "%.6g %s%s", factor * factor * area, stp_measure_unit(&unit),
                  stp_measure_unit(&unit)[0] != 0 ? "\u00b2" : "");
    }
}

void measure_unit_choice(viewer* v)
{
    static const char* const words[UNIT_COUNT] = {"File's unit", "mm", "cm", "m", "in", "ft"};
    bool known = v->scene != NULL && v->scene->directory->unit_metres > 0.0;
    gui_disable(!known);
    gui_choice("Unit", &v->settings.unit, words, UNIT_COUNT,
               known ? "Unit of lengths, coordinates and the scale bar"
                     : "This file does not specify its unit");
    gui_enable();
}

void page_measure(viewer* v)
{
    measure_state* m = &v->measure;
    gui_check("Measure with clicks", &m->on, "Each click on the model adds a point (M)");
    gui_check("Snap", &m->snaps, "Snap to corners and edges of the original triangles");
    measure_unit_choice(v);
    gui_space();
    if (m->count == 0) {
        gui_paragraph("Click two points for a distance, three for an angle and an area.");
        return;
    }
    if (m->count > 1) {
        show_results(v);
        gui_space();
    }
    gui_separator();
    for (int i = 0; i < m->count; ++i) {
        char text[128];
        measure_print_point(v, m->points[i], text, sizeof(text));
        gui_dim_text("Point %d", i + 1);
        gui_paragraph("%s", text);
    }
    gui_space();
    if (gui_wide_button("Undo point", 2, "Remove the last point (Backspace)")) {
        measure_undo(v);
    }
    gui_same_line();
    if (gui_wide_button("Clear", 2, "Remove all points")) {
        m->count = 0;
    }
}

void measure_overlay(const viewer* v, const stp_navigator* n)
{
    const measure_state* m = &v->measure;
    float x, y;
    for (int i = 0; i + 1 < m->count; ++i) {
        overlay_line(v, n, m->points[i], m->points[i + 1], line_color, 2.0f);
    }
    for (int i = 0; i < m->count; ++i) {
        if (overlay_place(v, n, m->points[i], &x, &y)) {
            gui_disc(x, y, 4.0f, line_color, 0x202020FF);
        }
    }
    for (int i = 0; i + 1 < m->count; ++i) {
        stp_vec3d middle = stp_scaled(stp_addd(m->points[i], m->points[i + 1]), 0.5);
        if (overlay_place(v, n, middle, &x, &y)) {
            char text[64];
            measure_print(v, stp_measure_distance(m->points[i], m->points[i + 1]).length, text,
                          sizeof(text));
            gui_plate(x, y - 14.0f * v->window.scale, text, line_color);
        }
    }
}
