// SPDX-License-Identifier: MIT
// The section box and section planes.
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"
#include "select/sections.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

int section_file_axis(const viewer* v, int axis)
{
    assert(axis >= 0 && axis < 3);
    return axis == 0 || v->scene->directory->up != 'z' ? axis : 3 - axis;
}

static const char* axis_name(const viewer* v, int axis)
{
    static const char* const names[3] = {"X", "Y", "Z"};
    return names[section_file_axis(v, axis)];
}

static double* axis_of(stp_vec3d* p, int axis)
{
    return axis == 0 ? &p->x : axis == 1 ? &p->y : &p->z;
}

void section_begin(viewer* v)
{
    v->section = (section_state){.box = camera_scene_box(v)};
}

stp_sections section_make(const viewer* v)
{
    const section_state* s = &v->section;
    stp_sections sections = {0};
    if (s->has_box && !stp_boxd_is_empty(s->box)) {
        (void)stp_sections_add_box(&sections, &s->box,
                                   v->explorer != NULL ? v->explorer->rounding : 0.0);
    }
    for (int i = 0; i < s->plane_count; ++i) {
        const section_plane* p = &s->planes[i];
        if (p->on) {
            stp_vec3d normal = p->flipped ? stp_scaled(p->normal, -1.0) : p->normal;
            stp_vec3d point = stp_addd(p->origin, stp_scaled(p->normal, (double)p->offset));
            (void)stp_sections_add_plane(&sections, point, normal);
        }
    }
    return sections;
}

/// Whether the first planes are those of stp_sections_add_box.
static bool find_box(const stp_sections* sections, stp_boxd* box)
{
    if (sections->count < 6) {
        return false;
    }
    for (int i = 0; i < 6; ++i) {
        stp_section_plane p = sections->planes[i];
        double along = *axis_of(&p.normal, i / 2);
        if (!(i % 2 == 0 ? along > 0.0 : along < 0.0) ||
            stp_dotd(p.normal, p.normal) != along * along) {
            return false;
        }
        *axis_of(i % 2 == 0 ? &box->max : &box->min, i / 2) = p.distance / along;
    }
    return !stp_boxd_is_empty(*box);
}

void section_take(viewer* v, const stp_sections* sections)
{
    section_begin(v);
    section_state* s = &v->section;
    stp_boxd box;
    assert(sections->count <= STP_SECTION_PLANES && "as many as the state has room for");
    s->has_box = find_box(sections, &box);
    if (s->has_box) { // without the margin, which section_make adds again
        double wider =
            stp_sections_box_margin(&box, v->explorer != NULL ? v->explorer->rounding : 0.0);
        stp_vec3d margin = {wider, wider, wider};
        stp_boxd inner = {stp_addd(box.min, margin), stp_subd(box.max, margin)};
        s->box = stp_boxd_is_empty(inner) ? box : inner;
    }
    for (uint32_t i = s->has_box ? 6 : 0; i < sections->count; ++i) {
        const stp_section_plane* p = &sections->planes[i];
        double length = sqrt(stp_dotd(p->normal, p->normal));
        stp_vec3d normal = stp_scaled(p->normal, 1.0 / length);
        s->planes[s->plane_count++] = (section_plane){
            .on = true, .normal = normal, .origin = stp_scaled(normal, p->distance / length)};
    }
}

static void add_plane(viewer* v, stp_vec3d point, stp_vec3d normal)
{
    section_state* s = &v->section;
    if (s->plane_count < SECTION_PLANES) {
        s->planes[s->plane_count++] =
            (section_plane){.on = true, .origin = point, .normal = normal};
    }
}

static void show_box(viewer* v, const stp_boxd* scene)
{
    section_state* s = &v->section;
    gui_check("Section box", &s->has_box, "Show only what is inside a box (K)");
    if (!s->has_box) {
        return;
    }
    for (int place = 0; place < 3; ++place) {
        int axis = section_file_axis(v, place);
        stp_boxd whole = *scene;
        double low = *axis_of(&whole.min, axis), high = *axis_of(&whole.max, axis);
        double size = high > low ? high - low : 1.0;
        float begin = (float)((*axis_of(&s->box.min, axis) - low) / size) * 100.0f;
        float end = (float)((*axis_of(&s->box.max, axis) - low) / size) * 100.0f;
        char from[32], to[32];
        snprintf(from, sizeof(from), "%s from", axis_name(v, axis));
        snprintf(to, sizeof(to), "%s to", axis_name(v, axis));
        if (gui_slider(from, &begin, 0.0f, 100.0f, "%.1f %%", "Lower side of the box")) {
            *axis_of(&s->box.min, axis) = low + 0.01 * (double)fminf(begin, end - 0.1f) * size;
        }
        if (gui_slider(to, &end, 0.0f, 100.0f, "%.1f %%", "Upper side of the box")) {
            *axis_of(&s->box.max, axis) = low + 0.01 * (double)fmaxf(end, begin + 0.1f) * size;
        }
    }
    stp_boxd chosen;
    bool any = v->explorer != NULL && explorer_chosen_box(v->explorer, &chosen);
    gui_disable(!any);
    if (gui_wide_button("Fit to part", 2, "Fit the box to the selected part")) {
        s->box = chosen;
    }
    gui_enable();
    gui_same_line();
    if (gui_wide_button("Fit to all", 2, "Fit the box to the whole model")) {
        s->box = *scene;
    }
}

static void show_plane(viewer* v, int index, double reach)
{
    section_plane* p = &v->section.planes[index];
    char text[48];
    snprintf(text, sizeof(text), "Plane %d", index + 1);
    gui_push_id(index);
    gui_check(text, &p->on, "Cut away everything beyond the plane");
    gui_same_line();
    if (gui_button("Flip", "Cut away the other side")) {
        p->flipped = !p->flipped;
    }
    gui_same_line();
    bool goes = gui_button("Remove", "Delete this plane");
    measure_print(v, (double)p->offset, text, sizeof(text));
    float offset = p->offset;
    if (gui_slider("Position", &offset, -(float)reach, (float)reach, text,
                   "Position along its normal")) {
        p->offset = offset;
    }
    gui_pop_id();
    if (goes) {
        section_state* s = &v->section;
        s->plane_count -= 1;
        memmove(p, p + 1, (size_t)(s->plane_count - index) * sizeof(*p));
    }
}

void page_section(viewer* v)
{
    section_state* s = &v->section;
    stp_boxd scene = camera_scene_box(v);
    if (v->scene == NULL || stp_boxd_is_empty(scene)) {
        gui_dim_text("Open a model first");
        return;
    }
    show_box(v, &scene);
    drawing_controls_show(v, DRAWING_PANEL_SECTION);
    gui_space();
    gui_separator();
    gui_text("Planes");
    stp_vec3d middle = stp_scaled(stp_addd(scene.min, scene.max), 0.5);
    stp_vec3d size = stp_subd(scene.max, scene.min);
    gui_disable(s->plane_count >= SECTION_PLANES);
    for (int place = 0; place < 3; ++place) {
        int axis = section_file_axis(v, place);
        stp_vec3d normal = {axis == 0, axis == 1, axis == 2};
        if (place > 0) {
            gui_same_line();
        }
        if (gui_wide_button(axis_name(v, axis), 3,
                            "Add a plane across this axis, through the middle")) {
            add_plane(v, middle, normal);
        }
    }
    if (gui_wide_button("On the clicked surface", 1, "Add a plane on the surface clicked last") &&
        v->has_picked) {
        add_plane(v, v->picked.position, v->picked.normal);
    }
    gui_enable();
    double reach = sqrt(stp_dotd(size, size));
    for (int i = 0; i < s->plane_count; ++i) {
        show_plane(v, i, reach);
    }
    if (s->plane_count > 0 && gui_wide_button("Remove all", 1, "Delete all planes")) {
        s->plane_count = 0;
    }
}

void section_overlay(const viewer* v, const stp_navigator* n)
{
    if (v->section.has_box) { // also without its panel: it shows that something may be cut away
        bool edits = v->settings.page == PAGE_SECTION;
        overlay_box(v, n, &v->section.box, edits ? 0xE6A040FF : 0xE6A040A0, edits ? 1.5f : 1.0f);
    }
    section_drag_overlay(v, n);
}
