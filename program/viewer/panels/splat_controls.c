// SPDX-License-Identifier: MIT
// Controls of the number of splats: by size, or a fixed number.
#include "program/viewer/model/splat_count.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>

uint32_t splats_all(const viewer* v)
{
    if (v->scene == NULL || v->settings.drawing.quality.reference) {
        return 0;
    }
    uint32_t method =
        stp_store_find_method(v->scene->directory, v->settings.drawing.quality.method);
    uint32_t all = method < SCENE_METHODS ? v->scene->splat_counts[method] : 0;
    return splat_count_is_chosen_of(all) ? all : 0;
}

bool viewer_mixes_methods(const viewer* v)
{
    const stp_quality quality = {.method = 0};
    return v->scene != NULL && stp_select_coarse_method(v->scene->directory, &quality) <
                                   stp_store_offered_methods(v->scene->directory);
}

uint32_t splats_count(const viewer* v)
{
    uint32_t all = splats_all(v);
    uint64_t count = v->settings.drawing.quality.splat_count;
    return all > 0 && count > 0 ? splat_count_within(count, all) : 0;
}

/// The number of splats listed at the moment.
static uint32_t listed_splats(const viewer* v)
{
    uint32_t all = splats_all(v);
    assert(all > 0 && "callers offer a number only then");
    bool drawn = v->picture != NULL && v->picture->scene == v->scene->serial;
    return splat_count_within(drawn ? v->picture->figures.cost.splats : all, all);
}

void splats_switch(viewer* v)
{
    if (v->settings.drawing.quality.splat_count > 0) {
        v->settings.drawing.quality.splat_count = 0;
    } else if (splats_all(v) > 0) {
        v->settings.drawing.quality.splat_count = listed_splats(v);
    } else {
        viewer_show_message(v, false, "There are no splats to draw by number");
    }
}

bool splats_take_key(viewer* v, SDL_Keycode key, bool fine)
{
    bool up = key == SDLK_PAGEUP;
    if (!up && key != SDLK_PAGEDOWN) {
        return false;
    }
    uint32_t all = splats_all(v), count = splats_count(v);
    if (all == 0) {
        viewer_show_message(v, false, "There are no splats to draw by number");
    } else {
        v->settings.drawing.quality.splat_count =
            splat_count_step(count > 0 ? count : listed_splats(v), all, up, fine);
    }
    return true;
}

void splats_print(char* text, size_t size, uint64_t count)
{
    char digits[24];
    int length = snprintf(digits, sizeof(digits), "%llu", (unsigned long long)count);
    size_t used = 0;
    for (int i = 0; i < length && used + 2 < size; ++i) {
        if (i > 0 && (length - i) % 3 == 0) {
            text[used++] = ',';
        }
        text[used++] = digits[i];
    }
    text[used] = 0;
}

/// The number as a slider and as a text field.
static void show_number(viewer* v, uint32_t all)
{
    char whole[32], label[64];
    uint64_t count = splats_count(v);
    splats_print(whole, sizeof(whole), all);
    snprintf(label, sizeof(label), "of %s###splat_slider", whole);
    bool changed = gui_log_count(label, &count, SPLAT_COUNT_MIN, all,
                                 "Total number of splats to draw, independent of distance. Page "
                                 "Up doubles it and Page Down halves it; with Shift, 5 % more or "
                                 "less");
    gui_last_place(v->splat_places[SPLAT_PLACE_SLIDER]);
    changed = gui_count("Number", &count, SPLAT_COUNT_MIN, all,
                        "Number of splats to draw, from 2 to all") ||
              changed;
    gui_last_place(v->splat_places[SPLAT_PLACE_NUMBER]);
    if (changed) {
        v->settings.drawing.quality.splat_count = splat_count_within(count, all);
    }
}

void splats_show(viewer* v)
{
    static const char* const words[] = {"By size", "By number"};
    uint32_t all = splats_all(v);
    bool counted = splats_count(v) > 0;
    int by = counted;
    gui_disable(all == 0);
    if (gui_choice("Splats", &by, words, 2,
                   all > 0 ? "By size: the splat size sets the number. By number: a fixed total "
                             "from 2 to all, without a frame-time limit (C switches)"
                           : "There are no splats to draw by number") &&
        (by == 1) != counted) {
        splats_switch(v);
    }
    gui_enable();
    gui_last_place(v->splat_places[SPLAT_PLACE_CHOICE]);
    if (splats_count(v) > 0) {
        show_number(v, all);
        return;
    }
    drawing_controls_show(v, DRAWING_PANEL_SPLAT_SIZE);
}
