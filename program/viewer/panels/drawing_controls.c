// SPDX-License-Identifier: MIT
// Controls of the drawing settings, from the table of program/drawing/drawing_table.h.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <stdlib.h>

static void show_choice(const drawing_row* row, drawing_settings* settings)
{
    int chosen = (int)drawing_get_index(row, settings);
    int count = (int)drawing_choice_count(row);
    if (gui_choice(row->label, &chosen, row->choices, count, row->tooltip)) {
        drawing_set_index(row, settings, (uint64_t)chosen);
    }
}

static void show_check(const drawing_row* row, drawing_settings* settings)
{
    bool on = drawing_get_index(row, settings) != 0;
    if (gui_check(row->label, &on, row->tooltip)) {
        drawing_set_index(row, settings, on);
    }
}

static void show_color(const drawing_row* row, drawing_settings* settings)
{
    uint8_t* bytes = drawing_color(row, settings);
    float color[3];
    for (int i = 0; i < 3; ++i) {
        color[i] = (float)bytes[i] / 255.0f;
    }
    if (gui_color(row->label, color, row->tooltip)) {
        for (int i = 0; i < 3; ++i) {
            bytes[i] = (uint8_t)(color[i] * 255.0f + 0.5f);
        }
    }
}

/// @param shown  the settings, with the scene's own values
static void show_number(const drawing_row* row, const drawing_settings* shown,
                        drawing_settings* settings)
{
    float value = drawing_get_number(row, shown), before = value;
    const char* usual = row->option.fallback;
    bool on = usual == NULL || value > 0.0f;
    if (usual != NULL && gui_check(row->label, &on, row->tooltip)) {
        value = on ? strtof(usual, NULL) : 0.0f;
    }
    if (on) {
        gui_push_id((int)row->offset);
        gui_slider(usual != NULL ? row->amount : row->label, &value, row->smallest, row->largest,
                   row->format, usual != NULL ? NULL : row->tooltip);
        gui_pop_id();
    }
    if (value != before) {
        drawing_set_number(row, settings, (double)value);
    }
}

void drawing_controls_show(viewer* v, drawing_panel panel)
{
    size_t count;
    const drawing_row* rows = drawing_rows(&count);
    drawing_settings* settings = &v->settings.drawing;
    drawing_settings shown = *settings;
    shown.style.eye_dome = cloud_page_eye_dome(v);
    for (size_t i = 0; i < count; ++i) {
        const drawing_row* row = &rows[i];
        if (row->panel != panel) {
            continue;
        }
        if (row->option.type == OPTION_FLOAT) {
            show_number(row, &shown, settings);
        } else if (row->option.type == OPTION_COLOR) {
            show_color(row, settings);
        } else if (drawing_choice_count(row) > 0) {
            show_choice(row, settings);
        } else {
            show_check(row, settings);
        }
    }
}
