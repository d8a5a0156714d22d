// SPDX-License-Identifier: MIT
// Frames the selected part or everything visible, again when the picture gets another shape.
#include "program/viewer/panels/panels.h"

#include <assert.h>

/// Bounds of all visible content; of the whole scene if nothing is visible.
static stp_boxd shown_box(const viewer* v, stp_farthest_store* content)
{
    stp_boxd box = stp_visible_bounds(content->store, content->visibility);
    if (stp_boxd_is_empty(box)) {
        content->visibility = NULL;
        box = camera_scene_box(v);
    }
    return box;
}

static void fit(const viewer* v, const stp_outline_item* part, stp_navigator* to)
{
    stp_boxd box = camera_scene_box(v);
    stp_sections sections = section_make(v);
    explorer* e = v->explorer;
    if (e == NULL) {
        stp_navigator_frame(to, &box, &sections);
        return;
    }
    stp_farthest_store content = {e->context, e->store, e->visibility};
    stp_placed_node placed = {part->node, part->transform};
    bool of_part = part->depth > 0 && explorer_item_box(e, part, &box);
    box = of_part ? box : shown_box(v, &content);
    if (!stp_boxd_is_empty(box)) {
        stp_vec3d pivot = stp_scaled(stp_addd(box.min, box.max), 0.5);
        stp_navigator_frame_content(to, &content, of_part ? &placed : NULL, pivot, &sections);
    }
}

static void frame(viewer* v, const stp_outline_item* part, stp_navigator* to)
{
    assert(v->scene != NULL);
    fit(v, part, to);
    v->framing =
        (framing_state){.on = true, .part = *part, .scene = v->scene->serial, .framed = *to};
}

bool framing_face(viewer* v, const char* name, stp_navigator* to)
{
    const stp_outline_item everything = {0};
    if (!stp_navigator_turn_to(to, name)) {
        return false;
    }
    frame(v, &everything, to);
    return true;
}

void framing_frame(viewer* v, stp_navigator* to)
{
    const stp_outline_item everything = {0};
    frame(v, v->explorer != NULL ? &v->explorer->chosen : &everything, to);
}

static bool is_same_camera(const stp_navigator* a, const stp_navigator* b)
{
    return a->eye.x == b->eye.x && a->eye.y == b->eye.y && a->eye.z == b->eye.z &&
           a->azimuth == b->azimuth && a->elevation == b->elevation && a->roll == b->roll &&
           a->fov_degrees == b->fov_degrees && a->ortho_height == b->ortho_height;
}

void framing_step(viewer* v)
{
    framing_state* f = &v->framing;
    stp_navigator* camera = v->glide_start >= 0.0 ? &v->glide_to : &v->camera;
    if (!f->on || v->scene == NULL || !v->has_camera) {
        return;
    }
    // a part's node has another number in another draft
    bool gone = f->part.depth > 0 && f->scene != v->scene->serial;
    if (gone || !is_same_camera(camera, &f->framed)) {
        f->on = false;
        return;
    }
    if (f->framed.width == v->camera.width && f->framed.height == v->camera.height) {
        return;
    }
    stp_navigator to = *camera;
    to.width = v->camera.width;
    to.height = v->camera.height;
    stp_outline_item part = f->part;
    frame(v, &part, &to);
    if (camera->pivot_chosen) {
        to.pivot = camera->pivot;
        to.pivot_chosen = true;
    }
    *camera = to;
}
