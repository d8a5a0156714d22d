// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/drawing/drawing_table.h"

#include <string.h>

void test_drawing_rows_are_complete(test_state* test)
{
    size_t count;
    const drawing_row* rows = drawing_rows(&count);
    for (size_t i = 0; i < count; ++i) {
        const drawing_row* row = &rows[i];
        bool number = row->option.type == OPTION_FLOAT;
        CHECK(row->option.name != NULL && row->option.help != NULL);
        CHECK(row->offset < sizeof(drawing_settings));
        CHECK((row->panel == DRAWING_PANEL_NONE) == (row->label == NULL));
        CHECK(row->panel == DRAWING_PANEL_NONE || (row->tooltip != NULL && row->key != NULL));
        CHECK(row->panel == DRAWING_PANEL_NONE || !number ||
              (row->smallest < row->largest && row->format != NULL));
        CHECK(row->label == NULL || row->option.fallback == NULL || row->amount != NULL);
        CHECK(row->key == NULL || !number || row->low < row->high);
    }
}

void test_drawing_options_lead_to_the_settings(test_state* test)
{
    option table[DRAWING_OPTION_ROOM];
    drawing_settings s;
    memset(&s, 0x5a, sizeof(s));
    (void)drawing_options_table(table, &s);
    CHECK(s.style.eye_dome == -1.0f && s.style.caps && !s.style.background);
    CHECK(s.quality.splat_size == 0.0f && !s.quality.reference);
    for (const option* o = table; o->name != NULL; ++o) {
        CHECK((const char*)o->value >= (const char*)&s &&
              (const char*)o->value < (const char*)(&s + 1));
        CHECK((o->given == &s.style.background) == (strcmp(o->name, "background") == 0));
    }
    drawing_settings viewer = drawing_settings_of_viewer();
    CHECK(viewer.style.background && viewer.style.background_color[2] == 230 && viewer.style.caps);
    CHECK(viewer.quality.splat_size == 1.0f && viewer.style.ambient_occlusion == 0.03f);
}
