// SPDX-License-Identifier: MIT
#include "base/math/color.h"
#include "lod/method.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/panels/state.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEGEND_STEPS = 64 };

/// Whether a colour is available for the shown scene.
static bool is_offered(const viewer* v, int color)
{
    stp_attribute a = point_color_attribute(color);
    return color != POINT_COLOR_AUTO &&
           (a == STP_ATTRIBUTES || stp_store_find_attribute(v->scene->store, a) != NULL);
}

static bool has_scale(int color)
{
    stp_attribute a = point_color_attribute(color);
    return color == POINT_COLOR_ELEVATION || (a != STP_ATTRIBUTES && !stp_attribute_is_distinct(a));
}

/// Default range of the scale. Elevations are read from the window's own file, once per scene.
static void default_range(viewer* v, double range[2])
{
    point_style* look = &v->look;
    const stp_store_attribute* a =
        stp_store_find_attribute(v->scene->store, point_color_attribute(look->color));
    if (a != NULL) {
        range[0] = a->low_percentile;
        range[1] = a->high_percentile;
        return;
    }
    if (look->scene != v->scene->serial) {
        look->elevation[0] = v->scene->bounds.min.y;
        look->elevation[1] = v->scene->bounds.max.y;
        if (v->explorer != NULL) {
            double found[2];
            if (point_colors_elevations(v->explorer->context, v->explorer->store, 0, found) ==
                STP_OK) {
                memcpy(look->elevation, found, sizeof(found));
            }
            look->scene = v->scene->serial;
        }
    }
    range[0] = look->elevation[0];
    range[1] = look->elevation[1];
}

static void find_range(viewer* v, double range[2])
{
    default_range(v, range);
    if (v->look.has_range) {
        range[0] = v->look.low;
        range[1] = v->look.high;
    }
}

void point_style_follow(viewer* v)
{
    int color = POINT_COLOR_AUTO;
    if (v->look.automatic && v->explorer != NULL &&
        point_colors_choose(v->explorer->store, 0, &color) == STP_OK) {
        v->look.color = color;
    }
}

void point_style_begin(viewer* v)
{
    const point_color_options* o = &v->options.colors;
    v->look = (point_style){.color = v->scene != NULL && is_offered(v, o->color) ? o->color
                                                                                 : POINT_COLOR_RGB,
                            .automatic = o->color == POINT_COLOR_AUTO};
    point_style_follow(v);
    if (o->color != v->look.color && !v->look.automatic) {
        viewer_show_message(v, false, "%s: its points have no %s", v->file,
                            stp_attribute_name(point_color_attribute(o->color)));
    } else if (o->range != NULL) {
        v->look.has_range = point_colors_read_range(o->range, &v->look.low, &v->look.high);
    }
    v->look.hides = o->classes != NULL && point_colors_read_classes(o->classes, v->look.shown);
}

void point_style_give(viewer* v, paint_request* request)
{
    const point_style* look = &v->look;
    stp_attribute a = point_color_attribute(look->color);
    double range[2] = {0.0, 1.0};
    if (has_scale(look->color)) {
        find_range(v, range);
    }
    request->points = (stp_store_coloring){.by_attribute = a != STP_ATTRIBUTES,
                                           .attribute = a != STP_ATTRIBUTES ? a : 0,
                                           .low = range[0],
                                           .high = range[1],
                                           .hides = look->hides};
    if (look->hides) {
        memcpy(request->points.shown, look->shown, sizeof(look->shown));
    }
    request->style.coloring = look->color == POINT_COLOR_ELEVATION ? STP_DRAW_ELEVATION
                              : look->color == POINT_COLOR_NORMAL  ? STP_DRAW_NORMALS
                                                                   : STP_DRAW_OWN_COLORS;
    request->style.elevation[0] = range[0];
    request->style.elevation[1] = range[1];
    if (request->style.coloring != STP_DRAW_OWN_COLORS) {
        request->style.filter = STP_FILTER_NONE; // pixel colours are computed only without blending
    }
    const point_color_options o = {.color = look->color, .classes = look->hides ? "" : NULL};
    request->quality.points_apart = request->quality.points_apart || point_colors_need_points(&o);
    if (!request->quality.reference) {
        uint32_t method = point_style_method(v, &request->quality.reference);
        request->quality.method = method != 0 ? method : request->quality.method;
        if (request->quality.reference && request->style.point_sizing == STP_POINTS_ADAPTIVE) {
            request->style.point_sizing = STP_POINTS_PIXELS;
            request->style.point_size = CLOUD_ORIGINAL_PIXELS;
        }
    }
}

uint32_t point_style_method(const viewer* v, bool* originals)
{
    const point_style* look = &v->look;
    const point_color_options o = {.color = look->color, .classes = look->hides ? "" : NULL};
    uint32_t chosen = v->settings.drawing.quality.method;
    *originals = false;
    if (v->scene == NULL || !point_colors_need_points(&o)) {
        return chosen;
    }
    const stp_store_directory* d = v->scene->directory;
    uint32_t usual = stp_store_find_method(d, chosen != 0 ? chosen : STP_METHOD_BLUE);
    uint32_t found = point_colors_find_method(&o, v->scene->store, usual);
    if (found != STP_STORE_NONE) {
        return d->methods[found].id;
    }
    *originals = point_colors_has_originals(&o, v->scene->store);
    return chosen;
}

/// Shows which method is drawn if the selected one lacks the attribute.
static void show_other_method(const viewer* v)
{
    bool originals;
    uint32_t chosen = v->settings.drawing.quality.method, drawn = point_style_method(v, &originals);
    const stp_store_directory* d = v->scene->directory;
    if (originals) {
        gui_dim_paragraph("Showing original points: splats lack this attribute.");
    } else if (drawn != 0 && stp_store_offered_methods(d) > 1 &&
               stp_store_find_method(d, chosen) != stp_store_find_method(d, drawn)) {
        gui_dim_paragraph("Showing splats of %s: other splats lack this attribute.",
                          stp_method_by_id(drawn)->title);
    }
}

static void show_choice(viewer* v)
{
    static const char* const titles[POINT_COLORS] = {
        "",        "Own",        "Intensity", "Elevation", "Class",         "Return",
        "Returns", "Scan angle", "Source",    "Time",      "Near infrared", "Normal"};
    const char* words[POINT_COLORS];
    int colors[POINT_COLORS], count = 0, chosen = 0;
    for (int i = 0; i < POINT_COLORS; ++i) {
        if (is_offered(v, i)) {
            chosen = i == v->look.color ? count : chosen;
            words[count] = titles[i];
            colors[count++] = i;
        }
    }
    assert(count > 0 && chosen < count && "own colours are always offered");
    if (gui_choice("Colour", &chosen, words, count,
                   "Colours points by a scan attribute, or everything by elevation or "
                   "normal")) {
        v->look.color = colors[chosen];
        v->look.automatic = false;
        v->look.has_range = false;
    }
}

static void show_range(viewer* v)
{
    double range[2];
    find_range(v, range);
    double step = (range[1] - range[0]) / 50.0;
    bool low = gui_number("From", &range[0], step, "%.6g", "Value at the violet end of the scale");
    bool high = gui_number("To", &range[1], step, "%.6g", "Value at the yellow end of the scale");
    if ((low || high) && range[0] < range[1]) {
        v->look.has_range = true;
        v->look.low = range[0];
        v->look.high = range[1];
    }
    if (v->look.has_range && gui_wide_button("Default range", 1, "2nd to 98th percentile")) {
        v->look.has_range = false;
    }
}

/// A row for each class of the file: visibility, colour, name and number of points.
static void show_classes(viewer* v)
{
    const stp_store_directory* d = v->scene->directory;
    for (uint32_t i = 0; i < d->attribute_value_count; ++i) {
        const stp_store_attribute_value* value = &d->attribute_values[i];
        const char* name = stp_class_name(value->value);
        const uint8_t* rgb = stp_class_color(value->value);
        const float color[4] = {stp_srgb8_to_linear(rgb[0]), stp_srgb8_to_linear(rgb[1]),
                                stp_srgb8_to_linear(rgb[2]), 1.0f};
        char label[64], count[32];
        bool shown = !v->look.hides || v->look.shown[value->value & 255] != 0;
        snprintf(label, sizeof(label), "%u %s", value->value, name != NULL ? name : "");
        page_print_count(count, sizeof(count), value->count);
        gui_push_id((int)i);
        if (gui_check(label, &shown, "Show points of this class")) {
            if (!v->look.hides) {
                memset(v->look.shown, 1, sizeof(v->look.shown));
                v->look.hides = true;
            }
            v->look.shown[value->value & 255] = shown ? 1 : 0;
        }
        gui_right_aligned(gui_text_width(count) + gui_text_height() + gui_gap());
        gui_square(color);
        gui_dim_text("%s", count);
        gui_pop_id();
    }
    if (v->look.hides &&
        gui_wide_button("Show points of all classes", 1, "Draw points of every class")) {
        v->look.hides = false;
    }
}

/// Shows the clicked point, if any.
static void show_picked(const viewer* v)
{
    const stp_pick* pick = &v->picked;
    if (!v->has_picked || v->explorer == NULL || pick->part.kind != STP_STORE_PART_POINTS) {
        gui_dim_paragraph("Click a point for its coordinates and attributes.");
        return;
    }
    char text[128];
    stp_store* store = v->explorer->store;
    const char* system = stp_store_coordinate_system(store);
    measure_print_point(v, pick->position, text, sizeof(text));
    gui_dim_text("Picked point");
    gui_paragraph("%s", text);
    if (system != NULL) {
        gui_dim_paragraph("%.120s", system);
    }
    uint32_t mask = pick->part.index < v->scene->directory->point_set_count
                        ? stp_store_point_attributes(store, pick->part.index)
                        : 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        double value; // large enough for any type
        if ((mask & stp_attribute_bit((stp_attribute)a)) == 0 ||
            stp_store_get_point_values(store, pick->part.index, (stp_attribute)a, pick->element, 1,
                                       &value) != STP_OK) {
            continue;
        }
        double number = stp_attribute_number((stp_attribute)a, &value, 0);
        const char* name = a == STP_ATTRIBUTE_CLASS ? stp_class_name((uint32_t)number) : NULL;
        gui_value(stp_attribute_name((stp_attribute)a), "%.12g%s%s", number,
                  name != NULL ? " " : "", name != NULL ? name : "");
    }
}

void point_style_show(viewer* v)
{
    if (v->scene == NULL || !gui_section("Colours", true)) {
        return;
    }
    show_choice(v);
    show_other_method(v);
    if (has_scale(v->look.color)) {
        show_range(v);
    }
    if (v->scene->directory->attribute_value_count > 0) {
        show_classes(v);
    }
    if (v->scene->directory->point_set_count > 0) {
        gui_separator();
        show_picked(v);
    }
}

void point_style_overlay(viewer* v)
{
    if (v->scene == NULL || !v->settings.guides || !v->shows_panels || !has_scale(v->look.color)) {
        return;
    }
    viewer_area a = v->picture_area;
    float unit = v->window.scale, width = 14.0f * unit;
    float height = 0.4f * a.height < 220.0f * unit ? 0.4f * a.height : 220.0f * unit;
    float x = a.x + 16.0f * unit, top = a.y + 0.5f * (a.height - height);
    for (int i = 0; i < LEGEND_STEPS; ++i) {
        const uint8_t* c = stp_color_map[255 - i * 255 / (LEGEND_STEPS - 1)];
        uint32_t color = (uint32_t)c[0] << 24 | (uint32_t)c[1] << 16 | (uint32_t)c[2] << 8 | 0xFFu;
        float y = top + height * (float)i / LEGEND_STEPS;
        gui_box(x, y, x + width, y + height / LEGEND_STEPS + 0.5f, color, color);
    }
    double range[2];
    char text[48];
    find_range(v, range);
    for (int i = 0; i < 3; ++i) {
        double part = 0.5 * (double)i;
        snprintf(text, sizeof(text), "%.6g", range[1] + (range[0] - range[1]) * part);
        gui_plate_at(x + width + 6.0f * unit, top + (float)part * height + 0.5f * gui_text_height(),
                     200.0f * unit, text, 0xF0F0F0FF);
    }
    gui_plate_at(x, top - 8.0f * unit, 240.0f * unit, point_color_name(v->look.color), 0xF0F0F0FF);
}
