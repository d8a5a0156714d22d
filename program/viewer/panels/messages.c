// SPDX-License-Identifier: MIT
// Messages to the user: the newest in the status line, earlier ones above it, and an explanation of
// an empty picture.
#include "base/core/clock.h"
#include "program/options/options.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const double shown_ms = 8000.0; // for notices; errors stay until dismissed

static bool is_current(const viewer_message* m, double now)
{
    return m->text[0] != 0 && (m->is_error || now - m->ms < shown_ms);
}

void viewer_show_message(viewer* v, bool is_error, const char* format, ...)
{
    viewer_message m = {.is_error = is_error, .ms = stp_clock_ms()};
    va_list list;
    va_start(list, format);
    char text[sizeof(m.text)];
    vsnprintf(text, sizeof(text), format, list);
    va_end(list);
    option_fields_name(text, m.text, sizeof(m.text));
    // unread messages stay, unless they repeat the new one
    viewer_message kept[MESSAGES];
    int count = 0;
    for (int i = 0; i < MESSAGES; ++i) {
        if (is_current(&v->messages[i], m.ms) && strcmp(v->messages[i].text, m.text) != 0) {
            kept[count++] = v->messages[i];
        }
    }
    memset(v->messages, 0, sizeof(v->messages));
    v->messages[0] = m;
    for (int i = 0; i < count && i + 1 < MESSAGES; ++i) {
        v->messages[i + 1] = kept[i];
    }
    viewer_redraw(v);
}

void messages_clear(viewer* v)
{
    memset(v->messages, 0, sizeof(v->messages));
}

bool messages_put_away(viewer* v)
{
    for (int i = 0; i < MESSAGES; ++i) {
        if (v->messages[i].is_error) {
            memmove(&v->messages[i], &v->messages[i + 1],
                    (size_t)(MESSAGES - 1 - i) * sizeof(v->messages[0]));
            v->messages[MESSAGES - 1] = (viewer_message){0};
            return true;
        }
    }
    return false;
}

const char* messages_newest(const viewer* v)
{
    return is_current(&v->messages[0], stp_clock_ms()) ? v->messages[0].text : NULL;
}

const char* messages_error(const viewer* v)
{
    for (int i = 0; i < MESSAGES; ++i) {
        if (v->messages[i].is_error) {
            return v->messages[i].text;
        }
    }
    return NULL;
}

/// Whether the scene's box is in view, tested with sample points.
static bool box_is_in_view(const viewer* v, const stp_navigator* n)
{
    enum { STEPS = 4 };
    stp_boxd box = camera_scene_box(v);
    stp_vec3d size = stp_subd(box.max, box.min);
    for (int i = 0; i < (STEPS + 1) * (STEPS + 1) * (STEPS + 1); ++i) {
        double x, y, depth;
        stp_vec3d p = {box.min.x + size.x * (i % (STEPS + 1)) / STEPS,
                       box.min.y + size.y * (i / (STEPS + 1) % (STEPS + 1)) / STEPS,
                       box.min.z + size.z * (i / (STEPS + 1) / (STEPS + 1)) / STEPS};
        if (stp_navigator_project(n, p, &x, &y, &depth) && x >= 0.0 && y >= 0.0 &&
            x < (double)n->width && y < (double)n->height) {
            return true;
        }
    }
    return false;
}

const char* messages_explain_empty(const viewer* v)
{
    stp_navigator n;
    const painter_picture* p = v->picture;
    if (p == NULL || v->scene == NULL || p->scene != v->scene->serial || p->number != v->request ||
        !p->is_empty || p->figures.missing > 0 || stp_boxd_is_empty(v->scene->bounds) ||
        !camera_of_picture(v, &n)) {
        return NULL;
    }
    bool hidden = v->explorer != NULL && v->explorer->mark_count > 0;
    bool sectioned = section_make(v).count > 0;
    if (!box_is_in_view(v, &n) || (!hidden && !sectioned)) {
        return "Nothing is in view (Home fits everything)";
    }
    return hidden && sectioned
               ? "Nothing is visible: everything in view is hidden or cut away (U shows all "
                 "parts, K turns off the section box)"
           : hidden ? "Nothing is visible: all parts in view are hidden (U shows all)"
                    : "Nothing is visible: everything in view is cut away (Section, F3)";
}

void messages_overlay(const viewer* v)
{
    viewer_area a = v->picture_area;
    const char* why = messages_explain_empty(v);
    if (why != NULL) {
        gui_plate(a.x + 0.5f * a.width, a.y + 0.5f * a.height, why, 0xE6E8EBFF);
    }
    double now = stp_clock_ms();
    float y = a.y + a.height;
    for (int i = v->shows_panels ? 1 : 0; i < MESSAGES; ++i) {
        const viewer_message* m = &v->messages[i];
        bool whole = v->shows_panels || m->is_error; // without panels, only errors
        if (is_current(m, now) && whole) {
            y -= 1.6f * gui_text_height();
            y -= gui_plate_at(a.x + 12.0f * v->window.scale, y, a.width - 24.0f * v->window.scale,
                              m->text, m->is_error ? 0xF0C090FF : 0xE6E8EBFF);
        }
    }
}
