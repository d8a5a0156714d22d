// SPDX-License-Identifier: MIT
// The state of the viewer as a JSON file, for tests and for programs that control the viewer.
#include "base/core/clock.h"
#include "program/present/view_cube.h"
#include "program/reports/describe.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <jansson.h>
#include <stdio.h>

static const double every_ms = 50.0;

static json_t* vector(stp_vec3d p)
{
    return json_pack("[f, f, f]", p.x, p.y, p.z);
}

static json_t* describe_camera(const viewer* v)
{
    stp_view view = {0};
    stp_navigator_write_view(&v->camera, &view);
    return json_pack("{s:o, s:o, s:o, s:f, s:f, s:o, s:b, s:f, s:f}", "eye", vector(view.eye),
                     "target", vector(view.target), "up", vector(view.up), "fov", view.fov_degrees,
                     "ortho_height", view.ortho_height, "pivot", vector(v->camera.pivot),
                     "pivot_chosen", (int)v->camera.pivot_chosen, "reach", v->camera.reach, "speed",
                     v->camera.speed);
}

static json_t* describe_picture(const viewer* v)
{
    viewer_area a = v->picture_area;
    const painter_picture* p = v->picture;
    if (p == NULL || v->scene == NULL || p->scene != v->scene->serial) {
        return json_null();
    }
    return json_pack(
        "{s:[f, f, f, f], s:i, s:i, s:b, s:i, s:I, s:I, s:I, s:f, s:f, s:f, s:I}", "area",
        (double)a.x, (double)a.y, (double)a.width, (double)a.height, "width", (int)p->image.width,
        "height", (int)p->image.height, "complete", (int)p->complete, "samples",
        (int)p->figures.samples, "splats", (json_int_t)p->figures.splats, "listed_splats",
        (json_int_t)p->figures.cost.splats, "triangles", (json_int_t)p->figures.triangles,
        "splat_size", stp_frame_splat_size(&p->figures.cost), "frame_ms", p->figures.frame_ms,
        "latency_ms", p->figures.latency_ms, "frames", (json_int_t)p->frame);
}

static json_t* describe_tools(const viewer* v)
{
    char chosen[1024] = "", place[160] = "";
    (void)panels_print_place(v, place, sizeof(place));
    explorer* e = v->explorer;
    if (e != NULL && e->ready && e->chosen.depth > 0) {
        (void)!stp_outline_path(e->outline, &e->chosen, chosen, sizeof(chosen));
    }
    json_t* points = json_array();
    for (int i = 0; points != NULL && i < v->measure.count; ++i) {
        json_array_append_new(points, vector(v->measure.points[i]));
    }
    stp_sections sections = section_make(v);
    return json_pack(
        "{s:[I, I], s:o, s:o, s:o, s:i, s:i, s:i, s:i, s:b, s:o, s:i, s:o, s:b, s:o, s:b, s:b}",
        "tinted", (json_int_t)v->selection.mask.visible, (json_int_t)v->selection.mask.hidden,
        "chosen", describe_json_text(chosen), "place", describe_json_text(place), "search",
        describe_json_text(v->search), "rows", e != NULL ? (int)e->row_count : 0, "found",
        e != NULL ? (int)e->found_count : 0, "marks", e != NULL ? (int)e->mark_count : 0,
        "section_planes", (int)sections.count, "measures", (int)v->measure.on, "points", points,
        "views", (int)v->views.count, "current_view", describe_json_text(v->current_view),
        "records", (int)v->record.on, "shot", describe_json_text(v->last_shot), "types",
        (int)gui_wants_keys(), "space_mouse", (int)space_mouse_is_connected(v->input.space_mouse));
}

/// View cube and scale bar: clickable positions of the sides, and length of the bar.
static json_t* describe_guides(const viewer* v)
{
    stp_navigator n;
    if (!camera_of_picture(v, &n)) {
        return json_null();
    }
    stp_scale_bar bar = orientation_scale_bar(v, &n);
    stp_measuring m = measure_units(v);
    json_t* sides = json_object();
    for (int i = 0; sides != NULL && i < STP_VIEW_CUBE_SIDES; ++i) {
        float x, y;
        const char* view = orientation_place(v, i, &x, &y);
        if (view != NULL) {
            json_object_set_new(sides, view, json_pack("[f, f]", (double)x, (double)y));
        }
    }
    return json_pack("{s:o, s:{s:f, s:f, s:s}}", "cube", sides, "scale_bar", "length", bar.length,
                     "pixels", bar.pixels, "unit", stp_measure_unit(&m));
}

/// The start page, its dialog, and the recent files.
static json_t* describe_start(const viewer* v)
{
    json_t* recent = json_array();
    const recent_files* files = start_recent(v->start);
    for (size_t i = 0; recent != NULL && i < files->count; ++i) {
        json_array_append_new(recent, describe_json_text(files->paths[i]));
    }
    return json_pack("{s:b, s:b, s:o, s:o, s:I, s:o}", "shown", (int)(v->file[0] == 0), "dialog",
                     (int)start_has_dialog(v), "folder", describe_json_text(start_folder(v)),
                     "typed", describe_json_text(start_typed(v)), "listed",
                     (json_int_t)start_listed(v), "recent", recent);
}

/// Handle positions of section planes and box, and offsets of planes.
static json_t* describe_handles(const viewer* v)
{
    json_t* handles = json_array();
    const section_state* s = &v->section;
    for (int i = 0; handles != NULL && i < s->plane_count + 6; ++i) {
        float x, y;
        if (section_handle(v, i, &x, &y)) {
            double offset = i < s->plane_count ? (double)s->planes[i].offset : 0.0;
            json_array_append_new(handles, json_pack("{s:[f, f], s:f}", "place", (double)x,
                                                     (double)y, "offset", offset));
        }
    }
    return handles;
}

/// The first match of the search, as its row shows it.
static json_t* describe_match(const viewer* v)
{
    explorer* e = v->explorer;
    char above[512];
    stp_outline_row row;
    if (e == NULL || !e->ready || e->found_count == 0) {
        return json_null();
    }
    const stp_outline_item* item = &e->found[0].item;
    json_t* label = describe_json_text(explorer_label(e, item, &row));
    return json_pack("{s:o, s:o}", "label", label, "detail",
                     describe_json_text(explorer_path_above(e, item, above, sizeof(above))));
}

/// The method that is drawn.
static json_t* describe_method(const viewer* v)
{
    const stp_store_directory* d = v->scene != NULL ? v->scene->directory : NULL;
    bool originals;
    return d != NULL && d->set_count > 0
               ? json_string(
                     d->methods[stp_store_find_method(d, point_style_method(v, &originals))].name)
               : json_null();
}

/// Requested number of splats (0: by size), the maximum, and positions of the widgets.
static json_t* describe_splats(const viewer* v)
{
    static const char* const names[SPLAT_PLACES] = {"choice", "slider", "field"};
    json_t* places = json_object();
    for (int i = 0; places != NULL && i < SPLAT_PLACES; ++i) {
        const float* p = v->splat_places[i];
        if (p[2] > p[0]) {
            json_object_set_new(
                places, names[i],
                json_pack("[f, f, f, f]", (double)p[0], (double)p[1], (double)p[2], (double)p[3]));
        }
    }
    return json_pack("{s:I, s:I, s:o}", "count", (json_int_t)splats_count(v), "all",
                     (json_int_t)splats_all(v), "places", places);
}

/// Up axis and unit of the scene shown.
static json_t* describe_axes(const viewer* v)
{
    char up[2] = {v->scene != NULL ? v->scene->directory->up : 0, 0};
    return json_pack("{s:s, s:f}", "up", up, "unit_metres",
                     v->scene != NULL ? v->scene->directory->unit_metres : 0.0);
}

static json_t* describe(const viewer* v)
{
    static const char* const states[] = {"idle", "working", "refining", "done", "failed"};
    static const char* const page_names[PAGE_COUNT] = {"none",    "statistics", "quality",
                                                       "section", "measure",    "views"};
    assert((size_t)v->news.state < sizeof(states) / sizeof(states[0]));
    assert(v->settings.page < PAGE_COUNT);
    return json_pack(
        "{s:o, s:I, s:s, s:I, s:b, s:b, s:I, s:I, s:s, s:b, s:b, s:b, s:s, s:o, s:o, s:s, s:o, "
        "s:o, "
        "s:s, s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:f, s:i, s:o}",
        "file", describe_json_text(v->file), "inputs", (json_int_t)v->inputs.count, "loading",
        states[v->news.state], "stores", (json_int_t)v->news.serial, "rests",
        (int)(viewer_is_idle(v) && v->dirty <= 0), "complete", (int)v->news.complete, "scene",
        (json_int_t)(v->scene != NULL ? v->scene->serial : 0), "shows", (json_int_t)v->shows,
        "page", page_names[v->settings.page], "panels", (int)v->shows_panels, "parts",
        (int)v->settings.parts, "help", (int)v->shows_help, "backend",
        v->picture != NULL && v->picture->gl ? "gl" : "cpu", "method", describe_method(v),
        "message", describe_json_text(v->messages[0].text), "hint",
        messages_explain_empty(v) != NULL ? messages_explain_empty(v) : "", "camera",
        describe_camera(v), "picture", describe_picture(v), "color",
        point_color_name(v->look.color), "hides", (int)v->look.hides, "tools", describe_tools(v),
        "guides", describe_guides(v), "match", describe_match(v), "start", describe_start(v),
        "handles", describe_handles(v), "splats", describe_splats(v), "eye_dome",
        (double)cloud_page_eye_dome(v), "point_sizing", (int)v->settings.drawing.style.point_sizing,
        "axes", describe_axes(v));
}

void report_write(viewer* v, bool last)
{
    const char* path = v->options.report;
    double now = stp_clock_ms();
    bool rests = viewer_is_idle(v) && v->dirty <= 0;
    if (path == NULL || (!last && now - v->report_ms < every_ms && rests == v->report_rests)) {
        return;
    }
    if (rests) { // a test that waits for this reads the screen next
        window_finish(&v->window);
    }
    v->report_ms = now;
    v->report_rests = rests;
    char aside[PATH_ROOM + 8];
    snprintf(aside, sizeof(aside), "%s.new", path);
    json_t* object = describe(v);
    bool written = object != NULL &&
                   json_dump_file(object, aside, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) == 0;
    if (!written || rename(aside, path) != 0) {
        (void)remove(aside);
        v->options.report = NULL;
        viewer_show_message(v, true, "%s: cannot write the report", path);
    }
    json_decref(object);
}
