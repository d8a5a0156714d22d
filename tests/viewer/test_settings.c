// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/viewer/model/settings.h"

#include <string.h>

void test_viewer_settings_are_kept(test_state* test)
{
    viewer_settings s = viewer_settings_default(), again = viewer_settings_default();
    s.budget_ms = 12.5f;
    s.page = PAGE_MEASURE;
    s.adapts = false;
    s.fovea = true;
    s.drawing.style.background_color[1] = 64;
    s.samples = 7;
    s.backend = BACKEND_OPENGL;
    s.unit = UNIT_FT;
    s.point_scale = 2.5f;
    s.drawing.style.point_sizing = STP_POINTS_UNITS;
    s.point_metres = 0.125f;
    s.drawing.style.eye_dome = 0.0f;
    s.guides = false;
    s.space_mouse_flies = true;
    s.drawing.quality.splat_count = 4294967294u;
    char* text = viewer_settings_print(&s);
    CHECK(text != NULL);
    CHECK(viewer_settings_parse(&again, text));
    CHECK(again.budget_ms == 12.5f && again.page == PAGE_MEASURE && !again.adapts && again.fovea);
    CHECK(again.drawing.style.background_color[1] == 64 && again.samples == 7 &&
          again.backend == BACKEND_OPENGL);
    CHECK(again.unit == UNIT_FT && again.point_scale == 2.5f && !again.guides &&
          again.space_mouse_flies);
    CHECK(again.drawing.quality.splat_count == 4294967294u &&
          viewer_settings_default().drawing.quality.splat_count == 0);
    CHECK(again.drawing.style.point_sizing == STP_POINTS_UNITS && again.point_metres == 0.125f);
    CHECK(again.drawing.style.eye_dome == 0.0f &&
          viewer_settings_default().drawing.style.eye_dome < 0.0f);
    CHECK(again.parts == s.parts &&
          again.drawing.quality.splat_size == s.drawing.quality.splat_size);
    free(text);
}

void test_viewer_settings_of_older_files_are_read(test_state* test)
{
    viewer_settings s = viewer_settings_default();
    CHECK(viewer_settings_detail(&s) == STP_POLICY_INSERTION);
    CHECK(viewer_settings_parse(&s, "{\"method\": 2, \"splats_by\": 3, \"light\": 1, \"filter\": 1,"
                                    " \"caps\": false, \"ambient_occlusion\": 4.5, \"red\": 0.5}"));
    CHECK(s.drawing.quality.policy == STP_POLICY_SWITCH && !s.drawing.quality.reference);
    CHECK(s.drawing.quality.method == 3 && s.drawing.style.headlight && !s.drawing.style.caps);
    CHECK(s.drawing.style.filter == STP_FILTER_EWA);
    CHECK(s.drawing.style.ambient_occlusion == 0.045f);
    CHECK(s.drawing.style.background_color[0] == 128 && s.drawing.style.background);
    CHECK(viewer_settings_parse(&s, "{\"method\": 3, \"filter\": 2, \"caps\": 1, \"red\": 2}"));
    CHECK(viewer_settings_detail(&s) == DETAIL_ORIGINAL && s.drawing.quality.reference);
    CHECK(s.drawing.style.filter == STP_FILTER_EWA && !s.drawing.style.caps);
    CHECK(s.drawing.style.background_color[0] == 128);
    char* text = viewer_settings_print(&s);
    CHECK(text != NULL && strstr(text, "\"method\": 3,") != NULL);
    CHECK(text != NULL && strstr(text, "\"ambient_occlusion\": 4.5") != NULL);
    CHECK(text != NULL && strstr(text, "\"light\": 1") != NULL);
    free(text);
}

void test_viewer_invalid_settings_change_nothing(test_state* test)
{
    static const char* const texts[] = {
        "",
        "[]",
        "{",
        "nonsense",
        "{\"budget_ms\": 1e9, \"page\": -1, \"samples\": 0}",
        "{\"budget_ms\": \"fast\", \"page\": true, \"adapts\": 3}",
        "{\"budget_ms\": 1e999}",
        "{\"splat_count\": -1}",
        "{\"splat_count\": 4294967295}",
        "{\"splat_count\": \"all\"}",
    };
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); ++i) {
        viewer_settings s = viewer_settings_default(), fresh = viewer_settings_default();
        CHECK(viewer_settings_parse(&s, texts[i]) == (i == 4 || i == 5 || i >= 7));
        CHECK(s.budget_ms == fresh.budget_ms && s.page == fresh.page && s.samples == fresh.samples);
        CHECK(s.adapts == fresh.adapts && s.drawing.quality.splat_count == 0);
    }
}
