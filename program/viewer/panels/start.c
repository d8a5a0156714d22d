// SPDX-License-Identifier: MIT
// The start page of a window without a file, and the file dialog, which does not depend on the
// desktop.
#define _XOPEN_SOURCE 700 // realpath
#include "import/reading/import.h"
#include "program/options/program.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/panels/state.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TYPED_ROOM = 1024, PLACES_MAX = 4 };

struct start_page {
    recent_files recent;
    folder_list folder;
    char typed[TYPED_ROOM];
    char message[512]; ///< why the typed path cannot be opened
    bool shown, focuses, shows_all;
    bool filters;  ///< the typed text filters the entries
    size_t chosen; ///< selected entry of the folder; count: none
};

start_page* start_create(void)
{
    start_page* s = calloc(1, sizeof(*s));
    if (s != NULL) {
        recent_load(&s->recent);
    }
    return s;
}

void start_destroy(start_page* s)
{
    if (s != NULL) {
        folder_destroy(&s->folder);
        free(s);
    }
}

void start_opened(start_page* s, const char* path)
{
    char whole[PATH_MAX];
    if (realpath(path, whole) != NULL) { // a procedural scene has no path
        recent_files now;
        recent_load(&now); // another window may have added entries
        recent_add(&now, whole);
        recent_save(&now);
        s->recent = now;
    }
}

const recent_files* start_recent(const start_page* s)
{
    return &s->recent;
}

static void go_to_folder(start_page* s, const char* path)
{
    if (folder_read(&s->folder, path, s->shows_all)) {
        s->chosen = s->folder.count;
        s->message[0] = 0;
    } else {
        snprintf(s->message, sizeof(s->message), "%.400s: cannot read it", path);
    }
}

/// Initial folder of the dialog: that of the last file, else the current folder.
static void begin_folder(start_page* s, const char* file)
{
    char path[PATH_MAX] = ".";
    if (file[0] == '/') {
        snprintf(path, sizeof(path), "%.*s", (int)(strrchr(file, '/') - file), file);
    }
    go_to_folder(s, path[0] != 0 ? path : "/");
    if (s->folder.path[0] == 0) {
        go_to_folder(s, "/");
    }
}

void start_show_dialog(viewer* v, bool shown)
{
    start_page* s = v->start;
    s->shown = shown;
    s->focuses = shown;
    s->message[0] = 0;
    if (shown && s->folder.path[0] == 0) {
        begin_folder(s, s->recent.count > 0 ? s->recent.paths[0] : v->file);
    }
    viewer_redraw(v);
}

bool start_has_dialog(const viewer* v)
{
    return v->start->shown;
}

const char* start_folder(const viewer* v)
{
    return v->start->folder.path;
}

const char* start_typed(const viewer* v)
{
    return v->start->typed;
}

/// The path that was typed. Relative paths start at the folder shown; "~" is the home folder.
/// @return false if it is too long
static bool find_path(const start_page* s, const char* typed, char path[PATH_MAX])
{
    const char* home = getenv("HOME");
    if (typed[0] == '~' && (typed[1] == '/' || typed[1] == 0) && home != NULL) {
        int length = snprintf(path, PATH_MAX, "%s%s", home, typed + 1);
        return length > 0 && length < PATH_MAX;
    }
    if (typed[0] == '/' || program_is_scene(typed)) {
        return snprintf(path, PATH_MAX, "%s", typed) < PATH_MAX;
    }
    return folder_join(&s->folder, typed, path);
}

/// Completes the last name of a typed path.
static bool complete_typed(const char* typed, char* text, size_t size, void* user)
{
    const start_page* s = user;
    const char* slash = strrchr(typed, '/');
    int above = slash != NULL ? (int)(slash + 1 - typed) : 0;
    char begun[PATH_MAX], path[PATH_MAX], name[TYPED_ROOM];
    folder_list list = {0};
    snprintf(begun, sizeof(begun), "%.*s", above, typed);
    bool found = find_path(s, above > 0 ? begun : ".", path) &&
                 folder_read(&list, path, s->shows_all) &&
                 folder_complete(&list, typed + above, name, sizeof(name)) &&
                 snprintf(text, size, "%s%s", begun, name) < (int)size;
    folder_destroy(&list);
    return found;
}

/// Opens a file or enters a folder.
static void take_path(viewer* v, const char* typed)
{
    start_page* s = v->start;
    char path[PATH_MAX], whole[PATH_MAX];
    bool fits = find_path(s, typed, path);
    folder_list probe = {0};
    if (!fits) {
        snprintf(s->message, sizeof(s->message), "the path is too long");
    } else if (folder_read(&probe, path, false)) {
        folder_destroy(&probe);
        go_to_folder(s, path);
        s->typed[0] = 0;
    } else if (!program_is_scene(path) && realpath(path, whole) == NULL) {
        snprintf(s->message, sizeof(s->message), "%.400s: no such file", path);
    } else {
        s->shown = false;
        s->typed[0] = 0;
        viewer_open(v, path);
    }
    viewer_redraw(v);
}

static void print_bytes(char* text, size_t size, uint64_t bytes)
{
    static const char* const units[] = {"bytes", "KB", "MB", "GB", "TB"};
    double value = (double)bytes;
    int unit = 0;
    while (value >= 1000.0 && unit < 4) {
        value /= 1000.0;
        unit += 1;
    }
    snprintf(text, size, unit > 0 && value < 10.0 ? "%.1f %s" : "%.0f %s", value, units[unit]);
}

/// Entries that the typed text leaves. @return their number; `kept` receives their places
static int filter_entries(const start_page* s, int kept[FOLDER_ENTRIES_MAX])
{
    bool filters = s->filters && strchr(s->typed, '/') == NULL && s->typed[0] != '~';
    int count = 0;
    for (size_t i = 0; i < s->folder.count; ++i) {
        if (!filters || folder_filter(&s->folder.entries[i], s->typed)) {
            kept[count++] = (int)i;
        }
    }
    return count;
}

size_t start_listed(const viewer* v)
{
    static int kept[FOLDER_ENTRIES_MAX]; // used by the window thread only
    return (size_t)filter_entries(v->start, kept);
}

static void show_entries(viewer* v)
{
    static int kept[FOLDER_ENTRIES_MAX]; // used by the window thread only
    start_page* s = v->start;
    int count = filter_entries(s, kept), first, last;
    char opened[PATH_MAX] = "";
    float room =
        (float)v->window.height - 10.0f * gui_line_height(); // leaves room for the widgets around
                                                             // the list
    gui_list_begin("entries",
                   fminf(fmaxf(room, 3.0f * gui_line_height()), 320.0f * v->window.scale));
    gui_rows_begin(count, &first, &last);
    for (int row = first; row < last; ++row) {
        int i = kept[row];
        const folder_entry* e = &s->folder.entries[i];
        char size[32] = "", name[300];
        if (!e->is_folder) {
            print_bytes(size, sizeof(size), e->bytes);
        }
        snprintf(name, sizeof(name), "%s%s", e->name, e->is_folder ? "/" : "");
        gui_push_id(i);
        int clicked = gui_list_row(name, size, (size_t)i == s->chosen);
        gui_pop_id();
        if ((clicked & GUI_ROW_CLICKED) != 0) {
            s->chosen = (size_t)i;
            s->filters = false;
            snprintf(s->typed, sizeof(s->typed), "%s", e->name);
        }
        if ((clicked & GUI_ROW_DOUBLE) != 0 || ((clicked & GUI_ROW_CLICKED) != 0 && e->is_folder)) {
            (void)folder_join(&s->folder, e->name, opened);
        }
    }
    gui_rows_end(count, last);
    if (count == 0) {
        gui_dim_text(s->folder.count > 0 ? "No name contains this" : "No models in this folder");
    } else if (s->folder.is_truncated) {
        gui_dim_text("First %d entries; type a name to open another", FOLDER_ENTRIES_MAX);
    }
    gui_list_end();
    if (opened[0] != 0) {
        take_path(v, opened);
    }
}

/// The home folder, and those of recent files.
static void show_places(viewer* v)
{
    start_page* s = v->start;
    const char* home = getenv("HOME");
    char go[PATH_MAX] = "";
    if (home != NULL && home[0] == '/' && gui_button("Home", home)) {
        snprintf(go, sizeof(go), "%s", home);
    }
    char shown[PLACES_MAX][PATH_MAX];
    int count = 0;
    for (size_t i = 0; i < s->recent.count && count < PLACES_MAX; ++i) {
        char* folder = shown[count];
        const char* path = s->recent.paths[i];
        snprintf(folder, PATH_MAX, "%.*s", (int)(strrchr(path, '/') - path), path);
        bool known = folder[0] == 0;
        for (int k = 0; k < count && !known; ++k) {
            known = strcmp(shown[k], folder) == 0;
        }
        if (known) {
            continue;
        }
        if (count > 0 || home != NULL) {
            gui_same_line();
        }
        gui_push_id(count++);
        if (gui_name_toggle(strrchr(folder, '/') + 1, false, 0.0f, folder)) {
            snprintf(go, sizeof(go), "%s", folder);
        }
        gui_pop_id();
    }
    if (go[0] != 0) {
        go_to_folder(s, go);
    }
}

/// Number of models in the folder shown.
static size_t count_models(const start_page* s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->folder.count; ++i) {
        const folder_entry* e = &s->folder.entries[i];
        count += !e->is_folder && stp_import_lists(e->name);
    }
    return count;
}

void start_dialog(viewer* v)
{
    start_page* s = v->start;
    viewer_area a = v->picture_area;
    char above[PATH_MAX];
    bool entered = false;
    gui_dialog_begin("open", a.x + 0.5f * a.width, a.y + 0.5f * a.height, 560.0f * v->window.scale);
    gui_text("Open a model");
    if (gui_button("Up", "Parent folder") && folder_join(&s->folder, "..", above)) {
        go_to_folder(s, above);
    }
    gui_same_line();
    gui_dim_text("%s", s->folder.path);
    show_places(v);
    show_entries(v);
    gui_fill_width();
    if (s->focuses) {
        gui_focus_next();
        s->focuses = false;
    }
    const char* hint =
        program_get()->make_scene != NULL ? "File name, path or scene:NAME" : "File name or path";
    if (gui_input_completed("##path", hint, s->typed, sizeof(s->typed), complete_typed, s,
                            &entered)) {
        s->filters = true;
    }
    if (s->message[0] != 0) {
        gui_paragraph("%s", s->message);
    }
    if (gui_check("List files of unsupported formats too", &s->shows_all,
                  "List files of unknown formats too")) {
        go_to_folder(s, s->folder.path);
    }
    size_t models = count_models(s);
    gui_disable(s->typed[0] == 0);
    bool pressed = gui_wide_button("Open", 3, "Open this file (Enter)");
    gui_enable();
    gui_same_line();
    gui_disable(models == 0);
    bool all = gui_wide_button("Open folder", 3, "Open all models of this folder as one scene");
    gui_enable();
    gui_same_line();
    if (gui_wide_button("Cancel", 3, "Escape")) {
        s->shown = false;
    }
    gui_panel_end();
    if (all) {
        s->shown = false;
        viewer_open(v, s->folder.path);
    }
    if ((pressed || entered) && s->typed[0] != 0) {
        char typed[TYPED_ROOM];
        snprintf(typed, sizeof(typed), "%s", s->typed);
        take_path(v, typed);
    }
}

bool start_open_recent(viewer* v, size_t index)
{
    start_page* s = v->start;
    if (index >= s->recent.count) {
        return false;
    }
    char path[PATH_MAX], whole[PATH_MAX];
    snprintf(path, sizeof(path), "%s", s->recent.paths[index]);
    if (realpath(path, whole) == NULL) {
        viewer_show_message(v, true, "%s: the file no longer exists", path);
        recent_remove(&s->recent, path);
        recent_save(&s->recent);
        return true;
    }
    s->shown = false;
    viewer_open(v, path);
    return true;
}

static void show_recent(viewer* v)
{
    const recent_files* r = &v->start->recent;
    for (size_t i = 0; i < r->count; ++i) {
        const char* slash = strrchr(r->paths[i], '/');
        char above[PATH_MAX];
        assert(slash != NULL && "recent paths are absolute");
        snprintf(above, sizeof(above), "%.*s", (int)(slash - r->paths[i]), r->paths[i]);
        gui_push_id((int)i);
        int clicked = gui_list_row(slash + 1, above, false);
        gui_pop_id();
        if ((clicked & GUI_ROW_CLICKED) != 0) {
            (void)start_open_recent(v, i);
            return;
        }
    }
}

void start_show(viewer* v)
{
    viewer_area a = v->picture_area;
    const char* error = messages_error(v);
    gui_dialog_begin("start", a.x + 0.5f * a.width, a.y + 0.5f * a.height,
                     520.0f * v->window.scale);
    gui_text("Stipple");
    gui_dim_text("Drop a model onto this window, or open one");
    gui_space();
    if (gui_wide_button("Open...", 1, "Choose a file (Ctrl+O)")) {
        start_show_dialog(v, true);
    }
    if (error != NULL) {
        gui_space();
        gui_paragraph("%s", error);
    }
    if (v->start->recent.count > 0) {
        gui_space();
        gui_text("Recent");
        show_recent(v);
    }
    gui_space();
    gui_text("Formats");
    char formats[1024];
    gui_dim_paragraph("%s", folder_formats(formats, sizeof(formats)));
    gui_space();
    gui_dim_text("H: keys and mouse");
    gui_panel_end();
}
