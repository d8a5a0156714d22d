// SPDX-License-Identifier: MIT
// Saved viewpoints and notes, kept in a file beside the model, and the model's own cameras.
#include "program/options/program.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OBJECTS_MAX = 1000 };

void views_begin(viewer* v)
{
    views_end(v);
    // a procedural scene has no file, so nothing can be saved beside it
    v->views_path = program_is_scene(v->file) ? NULL : stp_viewpoints_path(v->context, v->file);
    if (v->views_path != NULL &&
        stp_viewpoints_read(v->context, v->views_path, &v->views) != STP_OK) {
        stp_free(v->context, v->views_path); // do not overwrite a file that cannot be read
        v->views_path = NULL;
    }
}

void views_end(viewer* v)
{
    stp_viewpoints_destroy(v->context, &v->carried);
    v->carried = (stp_viewpoints){0};
    stp_viewpoints_destroy(v->context, &v->views);
    stp_free(v->context, v->views_path);
    v->views_path = NULL;
    v->views = (stp_viewpoints){0};
    v->current_view[0] = 0;
}

static void keep(viewer* v)
{
    if (v->views_path != NULL &&
        stp_viewpoints_write(v->context, v->views_path, &v->views) == STP_OK) {
        viewer_show_message(v, false, "Saved to %s", v->views_path);
    } else if (v->views_path == NULL) {
        viewer_show_message(v, false, "Viewpoints of this scene are kept until the window closes");
    }
}

/// The path of an item, if it is complete and can be saved as text. @return whether it is
static bool find_path(const explorer* e, const stp_outline_item* item, bool for_file,
                      char path[1024])
{
    enum { TRUNCATED = 1024 - 4 }; // this length or longer was truncated
    if (stp_outline_path(e->outline, item, path, 1024) != STP_OK || strlen(path) >= TRUNCATED) {
        return false;
    }
    json_t* text = for_file ? json_string(path) : json_null();
    json_decref(text);
    return text != NULL;
}

/// Lists up to OBJECTS_MAX hidden, isolated and ghosted parts by path.
/// @param left_out receives the number of parts that do not fit or have no path in UTF-8; NULL: the
///                 list stays in memory, where any path will do
/// @return their number
static size_t list_objects(viewer* v, stp_shown_object* objects, char (*paths)[1024],
                           size_t* left_out)
{
    static const stp_shown_as as[] = {[EXPLORER_HIDDEN] = STP_SHOWN_HIDDEN,
                                      [EXPLORER_ISOLATED] = STP_SHOWN_ISOLATED,
                                      [EXPLORER_GHOST] = STP_SHOWN_GHOST,
                                      [EXPLORER_FOCUSED] = STP_SHOWN_FOCUSED};
    explorer* e = v->explorer;
    size_t count = 0, all = e != NULL && e->ready ? e->mark_count : 0;
    for (size_t i = 0; i < all && count < OBJECTS_MAX; ++i) {
        const explorer_mark* m = &e->marks[i];
        stp_outline_row row;
        if (find_path(e, &m->item, left_out != NULL, paths[count]) &&
            stp_outline_describe(e->outline, &m->item, &row) == STP_OK) {
            objects[count] = (stp_shown_object){
                .as = as[m->how],
                .path = paths[count],
                .has_position = !stp_boxd_is_empty(row.bounds),
                .position = stp_scaled(stp_addd(row.bounds.min, row.bounds.max), 0.5)};
            count += 1;
        }
    }
    if (left_out != NULL) {
        *left_out = all - count;
    }
    return count;
}

static void name_view(const viewer* v, char* name, size_t size)
{
    if (v->view_name[0] != 0) {
        snprintf(name, size, "%s", v->view_name);
        return;
    }
    int number = 0;
    do {
        snprintf(name, size, "View %d", ++number);
    } while (stp_viewpoints_find(&v->views, name) != NULL);
}

void views_keep_hidden(viewer* v)
{
    stp_shown_object* objects = calloc(OBJECTS_MAX, sizeof(*objects));
    char(*paths)[1024] = calloc(OBJECTS_MAX, sizeof(*paths));
    stp_viewpoints_destroy(v->context, &v->carried);
    v->carried = (stp_viewpoints){0};
    if (objects != NULL && paths != NULL) {
        char name[] = "carried";
        stp_viewpoint viewpoint = {.name = name, .target = {0, 0, -1}, .up = {0, 1, 0}};
        viewpoint.objects = objects;
        viewpoint.object_count = list_objects(v, objects, paths, NULL);
        (void)!stp_viewpoints_put(v->context, &v->carried, &viewpoint);
    }
    free(objects);
    free(paths);
}

void views_save(viewer* v)
{
    if (v->scene == NULL) {
        return;
    }
    char name[128], path[1024];
    name_view(v, name, sizeof(name));
    stp_shown_object* objects = calloc(OBJECTS_MAX, sizeof(*objects));
    char(*paths)[1024] = calloc(OBJECTS_MAX, sizeof(*paths));
    stp_view view = {0};
    stp_navigator_write_view(&v->camera, &view);
    stp_viewpoint viewpoint = {.name = name,
                               .note = v->view_note[0] != 0 ? v->view_note : NULL,
                               .eye = view.eye,
                               .target = view.target,
                               .up = view.up,
                               .fov_degrees = view.fov_degrees,
                               .ortho_height = view.ortho_height,
                               .sections = section_make(v)};
    stp_annotation annotation = {.text = v->view_note};
    if (v->view_note[0] != 0 && v->has_picked && v->view_pins) {
        explorer* e = v->explorer;
        annotation.point = v->picked.position;
        bool named =
            e != NULL && e->ready && e->chosen.depth > 0 && find_path(e, &e->chosen, true, path);
        annotation.object = named ? path : NULL;
        viewpoint.annotations = &annotation;
        viewpoint.annotation_count = 1;
    }
    size_t left_out = 0;
    if (objects != NULL && paths != NULL) {
        viewpoint.objects = objects;
        viewpoint.object_count = list_objects(v, objects, paths, &left_out);
    }
    if (stp_viewpoints_put(v->context, &v->views, &viewpoint) == STP_OK) {
        snprintf(v->current_view, sizeof(v->current_view), "%s", name);
        v->view_name[0] = v->view_note[0] = 0;
        keep(v);
        if (left_out > 0) {
            viewer_show_message(
                v, false,
                "%zu parts saved as visible, because their paths are too long or not UTF-8",
                left_out);
        }
    }
    free(objects);
    free(paths);
}

static void restore_things(viewer* v, const stp_viewpoint* p)
{
    static const explorer_how how[] = {[STP_SHOWN_HIDDEN] = EXPLORER_HIDDEN,
                                       [STP_SHOWN_ISOLATED] = EXPLORER_ISOLATED,
                                       [STP_SHOWN_GHOST] = EXPLORER_GHOST,
                                       [STP_SHOWN_FOCUSED] = EXPLORER_FOCUSED};
    explorer* e = v->explorer;
    if (e == NULL || !e->ready) {
        return;
    }
    explorer_show_all(e);
    for (size_t i = 0; i < p->object_count; ++i) {
        const stp_shown_object* t = &p->objects[i];
        stp_outline_item item;
        bool found = false;
        if (stp_outline_by_path(e->outline, t->path, t->has_position ? &t->position : NULL, &item,
                                &found) == STP_OK &&
            found) {
            explorer_mark_item(e, &item, how[t->as]);
        }
    }
}

void views_restore_hidden(viewer* v)
{
    if (v->carried.count > 0 && v->explorer->ready) {
        restore_things(v, &v->carried.views[0]);
        stp_viewpoints_destroy(v->context, &v->carried);
        v->carried = (stp_viewpoints){0};
    }
}

static void go_to(viewer* v, const stp_viewpoint* p)
{
    stp_view view = {.fov_degrees = v->camera.fov_degrees};
    stp_navigator to = v->camera;
    stp_viewpoint_get_view(p, &view);
    stp_navigator_read_view(&to, &view);
    camera_glide(v, &to);
    section_take(v, &p->sections);
    restore_things(v, p);
    snprintf(v->current_view, sizeof(v->current_view), "%s", p->name);
}

bool views_begin_at(viewer* v, const char* name)
{
    const stp_viewpoint* p = stp_viewpoints_find(&v->views, name);
    stp_view view = {.fov_degrees = v->camera.fov_degrees};
    if (p == NULL) {
        return false;
    }
    stp_viewpoint_get_view(p, &view);
    stp_navigator_read_view(&v->camera, &view);
    section_take(v, &p->sections);
    // applied when the parts are known
    stp_viewpoints_destroy(v->context, &v->carried);
    v->carried = (stp_viewpoints){0};
    (void)!stp_viewpoints_put(v->context, &v->carried, p);
    snprintf(v->current_view, sizeof(v->current_view), "%s", name);
    return true;
}

static void show_saved(viewer* v)
{
    if (v->views.count == 0) {
        gui_dim_text("None yet");
    }
    for (size_t i = 0; i < v->views.count; ++i) {
        const stp_viewpoint* p = &v->views.views[i];
        bool goes = false;
        gui_push_id((int)i);
        float beside = gui_text_width("Remove") + 24.0f * v->window.scale;
        if (gui_name_toggle(p->name, strcmp(p->name, v->current_view) == 0, beside,
                            "Go to this "
                            "viewpoint")) {
            go_to(v, p);
        }
        gui_same_line();
        goes = gui_button("Remove", "Delete this viewpoint");
        if (p->note != NULL) {
            gui_dim_paragraph("%s", p->note);
        }
        gui_pop_id();
        if (goes) {
            (void)stp_viewpoints_remove(v->context, &v->views, p->name);
            keep(v);
            return;
        }
    }
}

static void show_cameras(viewer* v)
{
    const stp_store_directory* d = v->scene->directory;
    if (d->view_count == 0) {
        return;
    }
    gui_space();
    gui_text("Cameras in the file");
    gui_list_begin("cameras", 110.0f * v->window.scale);
    for (uint32_t i = 0; i < d->view_count; ++i) {
        const stp_store_view* stored = &d->views[i];
        gui_push_id((int)i);
        const char* name = stored->name != NULL && stored->name[0] != 0 ? stored->name : "unnamed";
        if (gui_name_toggle(name, false, 0.0f, "Go to this camera")) {
            stp_view view = {.eye = stored->eye,
                             .target = stored->target,
                             .up = stored->up,
                             .fov_degrees = stored->fov_degrees};
            stp_navigator to = v->camera;
            stp_navigator_read_view(&to, &view);
            camera_glide(v, &to);
        }
        gui_pop_id();
    }
    gui_list_end();
}

static void show_pictures(viewer* v)
{
    viewer_settings* s = &v->settings;
    gui_text("Pictures");
    gui_whole_number("Width", &s->shot_width, 16, 16384, "Width of saved pictures in pixels");
    gui_whole_number("Height", &s->shot_height, 16, 16384, "Height of saved pictures in pixels");
    gui_whole_number("Antialiasing##shot", &s->shot_samples, 1, 8,
                     "Samples per pixel, in each direction");
    gui_check("Make the background of saved pictures transparent", &v->shot_clear,
              "Transparent where the model is not");
    if (gui_wide_button("Save picture", 1, "Save a PNG into the pictures folder (F12)")) {
        shot_begin(v);
    }
    gui_space();
    gui_text("Flights");
    if (gui_wide_button(v->record.on ? "Stop" : "Record", 2,
                        "Record the camera's movement, for stipple fly (R)")) {
        record_switch(v);
    }
    gui_same_line();
    gui_disable(v->record.count < 2 || v->record.on);
    if (gui_wide_button(v->record.plays ? "Stop" : "Play", 2, "Play the last recorded flight")) {
        record_play(v);
    }
    gui_enable();
}

void page_views(viewer* v)
{
    if (v->scene == NULL) {
        gui_dim_text("Open a model first");
        return;
    }
    gui_text("Viewpoints");
    show_saved(v);
    gui_space();
    char name[128];
    name_view(v, name, sizeof(name));
    gui_input("Name", name, v->view_name, sizeof(v->view_name), NULL);
    gui_input("Note", "optional text", v->view_note, sizeof(v->view_note), NULL);
    gui_disable(!v->has_picked);
    gui_check("Pin note to the clicked point", &v->view_pins,
              "Show the note in the picture, at the point clicked last");
    gui_enable();
    if (gui_wide_button("Save viewpoint", 1,
                        "Save camera, sections and hidden parts in a file beside the model (V)")) {
        views_save(v);
    }
    show_cameras(v);
    gui_space();
    gui_separator();
    show_pictures(v);
}

void views_overlay(const viewer* v, const stp_navigator* n)
{
    const stp_viewpoint* p =
        v->current_view[0] != 0 ? stp_viewpoints_find(&v->views, v->current_view) : NULL;
    for (size_t i = 0; p != NULL && i < p->annotation_count; ++i) {
        float x, y;
        if (overlay_place(v, n, p->annotations[i].point, &x, &y)) {
            float up = 26.0f * v->window.scale;
            gui_line(x, y, x, y - up, 0xFFFFFFC0, 1.5f);
            gui_disc(x, y, 3.5f, 0xF2C14EFF, 0x202020FF);
            gui_plate(x, y - up, p->annotations[i].text, 0xF2E6C8FF);
        }
    }
}
