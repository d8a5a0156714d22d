// SPDX-License-Identifier: MIT
// The left panel: the tree of parts with a search, and properties of the selected part.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static void take_row_click(viewer* v, const stp_outline_item* item, int clicked, size_t row)
{
    explorer* e = v->explorer;
    if ((clicked & GUI_ROW_OPENED) != 0) {
        explorer_fold(e, row);
    } else if ((clicked & GUI_ROW_SWITCHED) != 0) {
        explorer_mark_item(e, item, EXPLORER_HIDDEN);
    } else if ((clicked & GUI_ROW_CLICKED) != 0) {
        explorer_choose(e, item, false);
    }
    if ((clicked & GUI_ROW_DOUBLE) != 0) {
        explorer_choose(e, item, false);
        camera_frame(v, false);
    }
}

/// One row of the tree or of search results. @return whether rows changed
static bool show_row(viewer* v, const explorer_row* r, size_t index, bool of_tree)
{
    explorer* e = v->explorer;
    stp_outline_item item = r->item; // a copy, because rows may move
    stp_outline_row about;
    char above[512];
    const char* label = explorer_label(e, &item, &about);
    gui_row row = {.label = label,
                   .detail = of_tree ? NULL : explorer_path_above(e, &item, above, sizeof(above)),
                   .depth = of_tree ? (int)item.depth - 1 : 0,
                   .has_children = of_tree && about.child_count > 0,
                   .open = r->open,
                   .selected = explorer_is_same(&item, &e->chosen),
                   .shown = !explorer_is_marked(e, &item, EXPLORER_HIDDEN),
                   .faint =
                       item.node == STP_STORE_NONE || explorer_is_marked(e, &item, EXPLORER_GHOST)};
    gui_push_id((int)index);
    int clicked = gui_tree_row(&row);
    gui_pop_id();
    take_row_click(v, &item, clicked, index);
    return (clicked & GUI_ROW_OPENED) != 0;
}

static void show_rows(viewer* v, bool of_tree)
{
    explorer* e = v->explorer;
    int count = (int)(of_tree ? e->row_count : e->found_count), first, last;
    gui_rows_begin(count, &first, &last);
    assert(first >= 0 && last <= count && "indices of rows");
    bool changed = false;
    for (int i = first; i < last && !changed; ++i) {
        changed = show_row(v, of_tree ? &e->rows[i] : &e->found[i], (size_t)i, of_tree);
    }
    gui_rows_end(count, last);
    for (int i = 0; of_tree && e->scrolls && i < count; ++i) {
        if (explorer_is_same(&e->rows[i].item, &e->chosen)) {
            e->scrolls = false;
            gui_scroll_to_row(i);
        }
    }
    if (changed) {
        viewer_redraw(v);
    }
}

static void show_marks(viewer* v)
{
    explorer* e = v->explorer;
    const stp_outline_item* chosen = &e->chosen;
    bool none = chosen->depth == 0;
    gui_disable(none || chosen->node == STP_STORE_NONE);
    bool hidden = explorer_is_marked(e, chosen, EXPLORER_HIDDEN);
    if (gui_wide_button(hidden ? "Show" : "Hide", 3, "Hide or show the selected part (X)")) {
        explorer_mark_item(e, chosen, EXPLORER_HIDDEN);
    }
    gui_same_line();
    if (gui_wide_button("Isolate", 3, "Show only the selected part (I)")) {
        explorer_mark_item(e, chosen, EXPLORER_ISOLATED);
    }
    gui_same_line();
    if (gui_wide_button("Ghost", 3, "Make the selected part see-through (G)")) {
        explorer_mark_item(e, chosen, EXPLORER_GHOST);
    }
    if (gui_wide_button("Ghost others", 2, "Make all other parts see-through (O)")) {
        explorer_mark_item(e, chosen, EXPLORER_FOCUSED);
    }
    gui_enable();
    gui_same_line();
    gui_disable(e->mark_count == 0);
    if (gui_wide_button("Show all", 2, "Show every part again (U)")) {
        explorer_show_all(e);
    }
    gui_enable();
}

/// Shows the material colours of the selected part as swatches with names.
static void show_materials(viewer* v)
{
    explorer* e = v->explorer;
    const stp_store_directory* d = stp_store_get_directory(e->store);
    if (e->materials_of != e->chosen.node) { // looked up once per selection
        e->materials = part_materials_find(e->store, e->chosen.node);
        e->materials_of = e->chosen.node;
    }
    for (uint32_t i = 0; i < e->materials.count; ++i) {
        const stp_store_material* m = &d->materials[e->materials.materials[i]];
        bool textured = m->base_color_texture.texture != STP_STORE_NONE;
        gui_push_id((int)i);
        gui_swatch(i == 0 ? "Material" : "", m->base_color, "%s%s",
                   m->name != NULL && m->name[0] != 0 ? m->name : "unnamed",
                   textured ? " (texture)" : "");
        gui_pop_id();
    }
    if (e->materials.more) {
        gui_value("", "and more");
    }
}

static void show_chosen(viewer* v)
{
    explorer* e = v->explorer;
    stp_outline_row row;
    char path[1024], text[64];
    if (e->chosen.depth == 0) {
        gui_dim_text("Click a part here or in the picture");
        return;
    }
    const char* label = explorer_label(e, &e->chosen, &row);
    gui_paragraph("%s", label);
    if (stp_outline_path(e->outline, &e->chosen, path, sizeof(path)) == STP_OK) {
        gui_dim_paragraph("%s", path);
    }
    if (row.id != NULL && row.id[0] != 0) {
        gui_value("Id", "%s", row.id);
    }
    if (row.triangle_count > 0) {
        page_print_count(text, sizeof(text), row.triangle_count);
        gui_value("Triangles", "%s", text);
    }
    if (row.point_count > 0) {
        page_print_count(text, sizeof(text), row.point_count);
        gui_value("Points", "%s", text);
    }
    if (!stp_boxd_is_empty(row.bounds)) {
        stp_vec3d size = stp_subd(row.bounds.max, row.bounds.min);
        const double sides[3] = {size.x, size.z, size.y};
        static const char* const names[3] = {"Width", "Depth", "Height"};
        for (int i = 0; i < 3; ++i) {
            measure_print(v, sides[i], text, sizeof(text));
            gui_value(names[i], "%s", text);
        }
    }
    show_materials(v);
}

void parts_show(viewer* v, float x, float y, float width, float height)
{
    explorer* e = v->explorer;
    gui_panel_begin("parts", x, y, width, height);
    if (e == NULL) {
        gui_dim_text("No parts yet");
        gui_panel_end();
        return;
    }
    gui_fill_width();
    if (v->finds) {
        gui_focus_next();
        v->finds = false;
    }
    bool entered = false;
    if (gui_input("##search", "Search names and ids", v->search, sizeof(v->search), &entered)) {
        explorer_search(e, v->search);
    }
    v->enters = v->enters || (entered && v->search[0] != 0);
    if (v->enters && !explorer_works(e)) { // select the first match
        v->enters = false;
        if (e->found_count > 0) {
            explorer_choose(e, &e->found[0].item, false);
            camera_frame(v, false);
        }
    }
    float details = 15.0f * (gui_text_height() + gui_gap()) + 2.0f * gui_line_height();
    details = details < 0.55f * height ? details : 0.55f * height;
    gui_list_begin("tree", -details);
    if (!e->ready) {
        gui_dim_text(e->failed ? "Cannot read the parts" : "Reading the parts...");
    } else if (v->search[0] != 0) {
        show_rows(v, false);
        if (e->found_count == 0 && !e->searches) {
            gui_dim_text("No matches");
        } else if (e->found_count == EXPLORER_FOUND_MAX) {
            gui_dim_text("First %d of more matches", EXPLORER_FOUND_MAX);
        }
    } else {
        show_rows(v, true);
        if (e->is_truncated) {
            gui_dim_text("Too many parts to list: search to find more");
        }
    }
    gui_list_end();
    show_marks(v);
    gui_separator();
    if (e->ready) {
        show_chosen(v);
    }
    gui_panel_end();
}

bool parts_take_key(viewer* v, SDL_Keycode key)
{
    static const struct {
        SDL_Keycode key;
        explorer_how how;
        const char* does;
    } keys[] = {
        {SDLK_x, EXPLORER_HIDDEN, "X hides it"},
        {SDLK_i, EXPLORER_ISOLATED, "I shows it alone"},
        {SDLK_g, EXPLORER_GHOST, "G makes it see-through"},
        {SDLK_o, EXPLORER_FOCUSED, "O makes all others see-through"},
    };
    explorer* e = v->explorer;
    if (e == NULL) {
        return false;
    }
    for (size_t i = 0; i < sizeof(keys) / sizeof(keys[0]); ++i) {
        if (key != keys[i].key) {
            continue;
        }
        if (e->chosen.depth == 0) {
            viewer_show_message(v, false, "No part is selected. Click one, then %s", keys[i].does);
        }
        explorer_mark_item(e, &e->chosen, keys[i].how);
        return true;
    }
    if (key == SDLK_u) {
        explorer_show_all(e);
    }
    return key == SDLK_u;
}
