// SPDX-License-Identifier: MIT
// The interface around the picture: bar, side panels, status line, help, and loading progress.
#include "program/viewer/panels/panels.h"

#include "program/viewer/window/gui.h"

#include <stdio.h>
#include <string.h>

static const float page_width = 300.0f; // pixels at scale 1
static const float edge_width = 5.0f;   // where the panel of parts is dragged, at scale 1

typedef struct page_entry {
    viewer_page page;
    const char* label;
    const char* tooltip;
    void (*show)(viewer* v);
} page_entry;

// most important first; the keys F2 to F6 follow this order
static const page_entry pages[] = {
    {PAGE_QUALITY, "Display", "Light, background, units, speed and quality (F2)", page_quality},
    {PAGE_SECTION, "Section", "Cut the model open (F3)", page_section},
    {PAGE_MEASURE, "Measure", "Distances, heights, angles, coordinates (F4)", page_measure},
    {PAGE_VIEWS, "Views", "Saved viewpoints, notes, pictures, flights (F5)", page_views},
    {PAGE_STATISTICS, "Statistics", "Frame times, splats and triangles, memory (F6)",
     page_statistics},
};
enum { PAGES = sizeof(pages) / sizeof(pages[0]) };

typedef struct shortcut {
    const char *keys, *meaning;
} shortcut;

static const shortcut mouse_shortcuts[] = {
    {"Left drag", "orbit around the pivot"},         {"Click", "select a part and set the pivot"},
    {"Middle drag", "pan; Shift and left drag too"}, {"Right drag", "look around"},
    {"Wheel", "zoom to the cursor; flying: speed"},
};
static const shortcut space_mouse_shortcuts[] = {
    {"SpaceMouse", "moves the model or the camera"},
    {"its buttons", "fit and level; model or camera"},
};
static const shortcut key_shortcuts[] = {
    {"W A S D, Q E", "fly; Q down, E up; Shift: faster"},
    {"F / Home", "fit the selected part / everything"},
    {"1 3 7 9", "front, right, top, iso view"},
    {"5", "perspective or parallel projection"},
    {"X I G O U", "hide, isolate, ghost, ghost others, show all"},
    {"K", "section box; F3: its handles"},
    {"M, Backspace", "measure, undo the last point"},
    {"V", "save a viewpoint"},
    {"R", "record a flight"},
    {"F12", "save a picture"},
    {"B", "switch between CPU and OpenGL"},
    {"N", "splats of the next method"},
    {"C", "splats by size or by number"},
    {"Page Up, Page Down", "more or fewer; Shift: by less"},
    {"P, Ctrl+F", "parts, search parts"},
    {"F2 to F6", "panels on the right"},
    {"Tab", "hide or show all panels"},
    {"F11", "full screen"},
    {"Ctrl+C", "copy the coordinates under the cursor"},
    {"Ctrl+O, Ctrl+1", "open a file, the most recent file"},
    {"H, Escape", "this help, back"},
    {"Ctrl+Q", "quit"},
};

static float bar_height(const viewer* v)
{
    return gui_line_height() + 14.0f * v->window.scale;
}

static float status_height(const viewer* v)
{
    return gui_text_height() + 10.0f * v->window.scale;
}

static bool has_page(const viewer* v)
{
    return v->shows_panels && v->settings.page != PAGE_NONE && v->file[0] != 0;
}

/// If there is no room for both panels, the right one is shown.
static bool has_parts(const viewer* v)
{
    float wanted = VIEWER_PARTS_WIDTH + page_width;
    bool room = (float)v->window.width > 2.0f * wanted * v->window.scale;
    return v->shows_panels && v->settings.parts && v->file[0] != 0 && (room || !has_page(v));
}

void panels_switch_parts(viewer* v)
{
    bool shown = has_parts(v);
    v->settings.parts = !shown;
    v->shows_panels = true;
    if (!shown && !has_parts(v)) { // there is no room for both
        v->settings.page = PAGE_NONE;
    }
}

viewer_area panels_layout(const viewer* v)
{
    float width = (float)v->window.width, height = (float)v->window.height;
    if (!v->shows_panels) {
        return (viewer_area){0.0f, 0.0f, width, height};
    }
    float top = bar_height(v), bottom = status_height(v);
    float right = has_page(v) ? page_width * v->window.scale : 0.0f;
    right = right < 0.6f * width ? right : 0.6f * width;
    float left = has_parts(v) ? v->settings.parts_width * v->window.scale : 0.0f;
    left = left < 0.6f * width ? left : 0.6f * width;
    float inner = height - top - bottom, middle = width - left - right;
    return (viewer_area){left, top, middle > 1.0f ? middle : 1.0f, inner > 1.0f ? inner : 1.0f};
}

bool panels_edge(const viewer* v, float x, float y)
{
    viewer_area a = v->picture_area;
    return has_parts(v) && x >= a.x && x < a.x + edge_width * v->window.scale && y >= a.y &&
           y < a.y + a.height && !gui_wants_mouse();
}

void panels_drag_edge(viewer* v, float x)
{
    v->settings.parts_width =
        stp_clamp(x / v->window.scale, VIEWER_PARTS_WIDTH_MIN, VIEWER_PARTS_WIDTH_MAX);
    viewer_redraw(v);
}

/// Shows that the edge of the panel of parts can be dragged.
static void show_edge(viewer* v)
{
    int ux, uy;
    viewer_area a = v->picture_area;
    SDL_GetMouseState(&ux, &uy);
    if (v->input.drag == DRAG_PARTS ||
        (v->input.button == 0 &&
         panels_edge(v, (float)ux * v->window.density, (float)uy * v->window.density))) {
        gui_resize_cursor();
        gui_line(a.x, a.y, a.x, a.y + a.height, 0x4DB3F2FF, 2.0f * v->window.scale);
    }
}

static const char* file_name(const viewer* v)
{
    const char* slash = strrchr(v->file, '/');
    return slash != NULL ? slash + 1 : v->file;
}

/// All panels in one menu, if there is no room for separate buttons.
static void show_panel_list(viewer* v)
{
    const char* words[PAGES + 3] = {"Picture", "Parts"};
    int chosen = has_parts(v) ? 1 : 0;
    for (int i = 0; i < PAGES; ++i) {
        words[2 + i] = pages[i].label;
        chosen = v->settings.page == pages[i].page ? 2 + i : chosen;
    }
    words[2 + PAGES] = "Help";
    gui_fill_width();
    if (gui_choice("##panels", &chosen, words, PAGES + 3, "Panel beside the picture")) {
        v->shows_help = chosen == 2 + PAGES;
        v->settings.page = chosen >= 2 && chosen < 2 + PAGES ? pages[chosen - 2].page : PAGE_NONE;
        v->settings.parts = chosen == 1;
    }
}

static void show_panel_buttons(viewer* v)
{
    if (gui_button("Open", "Open a model (Ctrl+O)")) {
        start_show_dialog(v, true);
    }
    gui_same_line();
    if (gui_toggle("Parts", has_parts(v), "The tree of parts (P)")) {
        panels_switch_parts(v);
    }
    gui_same_line();
    for (int i = 0; i < PAGES; ++i) {
        if (gui_toggle(pages[i].label, v->settings.page == pages[i].page, pages[i].tooltip)) {
            v->settings.page = v->settings.page == pages[i].page ? PAGE_NONE : pages[i].page;
        }
        gui_same_line();
    }
    if (gui_toggle("Help", v->shows_help, "Keys and mouse (H)")) {
        v->shows_help = !v->shows_help;
    }
}

static void show_bar(viewer* v)
{
    float scale = v->window.scale, whole = (float)v->window.width;
    char name[512] = "Stipple", more[32] = "";
    if (v->more > 0) {
        snprintf(more, sizeof(more), " and %zu more", v->more);
    }
    if (v->file[0] != 0) {
        snprintf(name, sizeof(name), "%.400s%s", file_name(v), more);
    }
    float width = gui_text_width("Parts") + gui_text_width("Open") + 48.0f * scale;
    for (int i = 0; i < PAGES; ++i) {
        width += gui_text_width(pages[i].label) + 24.0f * scale;
    }
    width += gui_text_width("Help") + 16.0f * scale;
    gui_bar_begin("bar", 0.0f, 0.0f, whole, bar_height(v), false);
    float room = whole - 24.0f * scale;
    bool named = width + gui_text_width(name) + 16.0f * scale < room;
    if (named) {
        gui_text("%s", name);
        gui_right_aligned(width);
    }
    if (width < room) {
        show_panel_buttons(v);
    } else {
        show_panel_list(v);
    }
    gui_panel_end();
}

static void show_page(viewer* v)
{
    float width = page_width * v->window.scale, top = bar_height(v);
    width = width < 0.6f * (float)v->window.width ? width : 0.6f * (float)v->window.width;
    gui_panel_begin("page", (float)v->window.width - width, top, width,
                    (float)v->window.height - top - status_height(v));
    for (int i = 0; i < PAGES; ++i) {
        if (pages[i].page == v->settings.page) {
            pages[i].show(v);
        }
    }
    gui_panel_end();
}

bool panels_print_place(const viewer* v, char* text, size_t size)
{
    int ux, uy;
    stp_vec3d point;
    SDL_GetMouseState(&ux, &uy);
    bool sees = !gui_wants_mouse() && camera_seen(v, (float)ux * v->window.density,
                                                  (float)uy * v->window.density, &point);
    if (sees) {
        measure_print_point(v, point, text, size);
    }
    return sees;
}

/// What is under the cursor, right-aligned.
static void show_place(const viewer* v)
{
    char text[160];
    if (panels_print_place(v, text, sizeof(text))) {
        gui_right_aligned(gui_text_width(text));
        gui_dim_text("%s", text);
    }
}

/// Text for the stage of the build.
static const char* name_stage(const viewer* v)
{
    static const char* const words[][2] = {{"import", "reading the file"},
                                           {"partition", "splitting into nodes"},
                                           {"clusters", "compressing triangles"},
                                           {"surfels", "creating splats"},
                                           {"write", "writing"}};
    for (size_t i = 0; i < sizeof(words) / sizeof(words[0]); ++i) {
        if (strcmp(v->news.stage, words[i][0]) == 0) {
            return words[i][1];
        }
    }
    return v->news.stage[0] != 0 ? v->news.stage : "opening the file";
}

/// Figures of the picture.
static void show_picture_line(const viewer* v)
{
    const paint_figures* f = &v->picture->figures;
    const char* more = v->picture->complete ? "" : "   refining...";
    uint32_t width = v->picture->image.width, height = v->picture->image.height;
    if (splats_count(v) > 0) {
        char drawn[32], all[32];
        splats_print(drawn, sizeof(drawn), f->splats);
        splats_print(all, sizeof(all), splats_all(v));
        gui_dim_text("%u x %u   %.1f ms   %s of %s splats%s", width, height, f->frame_ms, drawn,
                     all, more);
    } else {
        gui_dim_text("%u x %u   %.1f ms   splat size %.1f px%s", width, height, f->frame_ms,
                     stp_frame_splat_size(&f->cost), more);
    }
}

static void show_status(viewer* v)
{
    float height = status_height(v);
    gui_bar_begin("status", 0.0f, (float)v->window.height - height, (float)v->window.width, height,
                  true);
    const char* message = messages_newest(v);
    if (message != NULL) {
        gui_text("%s", message);
    } else if (v->news.state == LOADER_REFINING) {
        gui_text("Building: %s %.0f %%", name_stage(v),
                 100.0 * (v->news.overall >= 0.0 ? v->news.overall : v->news.fraction));
    } else if (v->picture != NULL && v->scene != NULL) {
        show_picture_line(v);
    } else {
        gui_dim_text("Drop a model or a .stip file onto the window, or press Ctrl+O");
    }
    show_place(v);
    gui_panel_end();
}

static void show_shortcuts(const shortcut* list, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        gui_value(list[i].keys, "%s", list[i].meaning);
    }
}

static void show_help(viewer* v)
{
    viewer_area a = v->picture_area;
    gui_dialog_begin("help", a.x + 0.5f * a.width, a.y + 0.5f * a.height, 460.0f * v->window.scale);
    gui_text("Mouse");
    show_shortcuts(mouse_shortcuts, sizeof(mouse_shortcuts) / sizeof(mouse_shortcuts[0]));
    if (space_mouse_is_connected(v->input.space_mouse)) {
        show_shortcuts(space_mouse_shortcuts,
                       sizeof(space_mouse_shortcuts) / sizeof(space_mouse_shortcuts[0]));
    }
    gui_space();
    gui_text("Keys");
    show_shortcuts(key_shortcuts, sizeof(key_shortcuts) / sizeof(key_shortcuts[0]));
    gui_space();
    if (gui_button("Close", "Escape")) {
        v->shows_help = false;
    }
    gui_panel_end();
}

/// The central dialog while there is no picture.
static void show_waiting(viewer* v)
{
    viewer_area a = v->picture_area;
    gui_dialog_begin("waiting", a.x + 0.5f * a.width, a.y + 0.5f * a.height,
                     420.0f * v->window.scale);
    const char* error = messages_error(v);
    if (error != NULL) {
        gui_text("Cannot show %s", file_name(v));
        gui_space();
        gui_paragraph("%s", error);
        gui_space();
        if (gui_wide_button("Open...", 1, "Choose another file (Ctrl+O)")) {
            start_show_dialog(v, true);
        }
    } else if (v->scene != NULL && v->shown_file_number == v->file_number &&
               stp_boxd_is_empty(v->scene->bounds)) {
        gui_text("%s has no visible content", file_name(v));
    } else if (v->scene != NULL && v->shown_file_number == v->file_number) {
        gui_text("Drawing the first picture of %s", file_name(v));
    } else {
        double part = v->news.overall >= 0.0 ? v->news.overall : v->news.fraction;
        char text[96];
        snprintf(text, sizeof(text), "%.0f %%", 100.0 * part);
        gui_text("Loading %s", file_name(v));
        gui_progress((float)part, text);
        if (v->news.total > 0) {
            gui_dim_text("%s: %llu of %llu %s", name_stage(v), (unsigned long long)v->news.done,
                         (unsigned long long)v->news.total, v->news.unit);
        } else {
            gui_dim_text("%s", name_stage(v));
        }
    }
    gui_panel_end();
}

void panels_show(viewer* v)
{
    v->picture_area = panels_layout(v);
    memset(v->splat_places, 0, sizeof(v->splat_places));
    bool has_picture =
        v->scene != NULL && v->picture != NULL && v->shown_file_number == v->file_number;
    overlay_show(v);
    if (v->shows_panels) {
        show_bar(v);
        show_status(v);
        if (has_page(v)) {
            show_page(v);
        }
        if (has_parts(v)) {
            float top = bar_height(v);
            parts_show(v, 0.0f, top, v->picture_area.x,
                       (float)v->window.height - top - status_height(v));
            show_edge(v);
        }
    }
    if (start_has_dialog(v)) {
        start_dialog(v);
    } else if (v->shows_help) {
        show_help(v);
    } else if (v->file[0] == 0) {
        start_show(v);
    } else if (!has_picture || stp_boxd_is_empty(v->scene->bounds)) {
        show_waiting(v);
    }
}
