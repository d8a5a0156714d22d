// SPDX-License-Identifier: MIT
#include "program/drawing/show_options.h"

#include "select/sections.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

const option* show_options_table(option* table, show_options* o)
{
    const option list[SHOW_OPTION_ROOM] = {
        {.name = "section",
         .type = OPTION_TEXTS,
         .argument = "AXIS:AT|A,B,C,D",
         .help = "cut away everything beyond a plane: perpendicular to x, y, z, -x, -y or -z at "
                 "a coordinate or a percentage of the scene (x:2.5, -z:50%), or where A x + B y "
                 "+ C z > D; up to 14 planes, including six per box",
         .value = &o->sections,
         .group = "Objects"},
        {.name = "section-box",
         .type = OPTION_TEXTS,
         .argument = "X,Y,Z,X,Y,Z",
         .help = "cut away everything outside a box, given by two corners; numbers may be "
                 "percentages of the scene (0%,0%,0%,50%,100%,100%)",
         .value = &o->boxes,
         .rare = true},
        {.name = "hide",
         .type = OPTION_TEXTS,
         .argument = "NAME",
         .help = "hide objects by name, path (house/door), id or number (#7)",
         .value = &o->hide},
        {.name = "isolate",
         .type = OPTION_TEXTS,
         .argument = "NAME",
         .help = "draw only these objects",
         .value = &o->isolate},
        {.name = "ghost",
         .type = OPTION_TEXTS,
         .argument = "NAME",
         .help = "draw objects see-through; \"others\" means all objects except those of "
                 "--isolate",
         .value = &o->ghost,
         .rare = true},
        {0},
    };
    memcpy(table, list, sizeof(list));
    return table;
}

/// Reads comma-separated numbers or percentages. @return whether there are exactly as many as
/// expected
static bool read_numbers(const char* text, size_t count, double* numbers, bool* percent)
{
    for (size_t i = 0; i < count; ++i) {
        char* end;
        if (strchr("+-.0123456789", *text) == NULL || *text == '\0') {
            return false;
        }
        numbers[i] = strtod(text, &end);
        percent[i] = *end == '%';
        end += percent[i] ? 1 : 0;
        if (end == text || !isfinite(numbers[i]) || *end != (i + 1 < count ? ',' : '\0')) {
            return false;
        }
        text = end + 1;
    }
    return true;
}

/// A coordinate, or a percentage of the extent of the scene.
static double place_of(double number, bool percent, const stp_boxd* box, int axis)
{
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    return percent ? low[axis] + 0.01 * number * (high[axis] - low[axis]) : number;
}

static stp_vec3d axis_vector(int axis, double length)
{
    return (stp_vec3d){axis == 0 ? length : 0.0, axis == 1 ? length : 0.0,
                       axis == 2 ? length : 0.0};
}

/// @return false if the text is not a plane or there is no room
static bool add_plane(const char* text, const stp_boxd* box, double rounding,
                      stp_sections* sections)
{
    double numbers[4];
    bool percent[4];
    const char* axis = text + (*text == '-' || *text == '+' ? 1 : 0);
    if (*axis >= 'x' && *axis <= 'z' && axis[1] == ':') {
        if (!read_numbers(axis + 2, 1, numbers, percent)) {
            return false;
        }
        int k = *axis - 'x';
        double at = place_of(numbers[0], percent[0], box, k);
        if (percent[0] && (numbers[0] <= 0.0 || numbers[0] >= 100.0)) { // beyond what lies there
            at += numbers[0] <= 0.0 ? -rounding : rounding;
        }
        return stp_sections_add_plane(sections, axis_vector(k, at),
                                      axis_vector(k, *text == '-' ? -1.0 : 1.0));
    }
    if (!read_numbers(text, 4, numbers, percent) || percent[0] || percent[1] || percent[2] ||
        percent[3]) {
        return false;
    }
    stp_vec3d normal = {numbers[0], numbers[1], numbers[2]};
    double square = stp_dotd(normal, normal);
    return square > 0.0 &&
           stp_sections_add_plane(sections, stp_scaled(normal, numbers[3] / square), normal);
}

static bool add_box(const char* text, const stp_boxd* scene, double rounding,
                    stp_sections* sections)
{
    double n[6];
    bool percent[6];
    stp_boxd box = stp_boxd_empty();
    if (!read_numbers(text, 6, n, percent)) {
        return false;
    }
    for (size_t i = 0; i < 6; i += 3) {
        stp_boxd_add(&box, (stp_vec3d){place_of(n[i], percent[i], scene, 0),
                                       place_of(n[i + 1], percent[i + 1], scene, 1),
                                       place_of(n[i + 2], percent[i + 2], scene, 2)});
    }
    return stp_sections_add_box(sections, &box, rounding);
}

/// @param rounding how far content may lie outside `box`, the bounds of the scene
/// @return 0, or 2 (message printed)
static int add_sections(const show_options* o, const stp_boxd* box, double rounding,
                        stp_sections* sections)
{
    for (uint32_t i = 0; i < o->sections.count; ++i) {
        if (!add_plane(o->sections.texts[i], box, rounding, sections)) {
            return tool_usage_error("--section must be AXIS:AT (x:2.5, -z:50%%) or A,B,C,D, with "
                                    "at most %d planes including those of boxes, not %s",
                                    STP_SECTION_PLANES, o->sections.texts[i]);
        }
    }
    for (uint32_t i = 0; i < o->boxes.count; ++i) {
        if (!add_box(o->boxes.texts[i], box, rounding, sections)) {
            return tool_usage_error("--section-box must be X,Y,Z,X,Y,Z, each a number or a "
                                    "percentage, with at most %d planes (six per box), not %s",
                                    STP_SECTION_PLANES, o->boxes.texts[i]);
        }
    }
    return 0;
}

int show_options_check(const show_options* o)
{
    stp_sections sections = {0};
    stp_boxd box = {{0, 0, 0}, {1, 1, 1}};
    return add_sections(o, &box, 0.0, &sections);
}

stp_result scene_show_outline(scene_show* show, stp_outline** outline)
{
    bool ready = show->outline != NULL;
    stp_result result = STP_OK;
    if (!ready) {
        result = stp_outline_create(show->context, show->store, &show->outline);
    }
    result = result == STP_OK ? stp_outline_prepare(show->outline, 0, &ready) : result;
    *outline = show->outline;
    return result;
}

static stp_result set_item(scene_show* show, const stp_outline_item* item, stp_show as)
{
    stp_placed_node object = {.node = item->node, .transform = item->transform};
    return stp_visibility_set(show->visibility, &object, as);
}

/// Changes how all objects of a name are shown. @return 0, 1 or 2 (message printed)
static int set_named(scene_show* show, const char* name, stp_show as)
{
    stp_outline* outline = show->outline;
    assert(outline != NULL && show->visibility != NULL && "make_visibility was called");
    uint32_t found = 0;
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < stp_outline_object_count(outline) && result == STP_OK; ++i) {
        stp_outline_item item;
        bool named = false;
        result = stp_outline_is_named(outline, i, name, &named);
        if (result == STP_OK && named) {
            result = stp_outline_item_of(outline, i, &item);
            bool seen = result == STP_OK && item.node != STP_STORE_NONE;
            found += seen ? 1 : 0;
            result = seen ? set_item(show, &item, as) : result;
        }
    }
    if (result == STP_OK && found == 0) {
        stp_outline_item item;
        bool is_there;
        result = stp_outline_by_path(outline, name, NULL, &item, &is_there);
        found = result == STP_OK && is_there && item.node != STP_STORE_NONE ? 1 : 0;
        result = found != 0 ? set_item(show, &item, as) : result;
    }
    if (result == STP_OK && found == 0) {
        return tool_usage_error("there is no object named %s with visible content", name);
    }
    return result == STP_OK ? 0 : 1;
}

static int set_all_named(scene_show* show, const option_texts* names, stp_show as)
{
    int code = 0;
    for (uint32_t i = 0; i < names->count && code == 0; ++i) {
        bool others = as == STP_SHOW_GHOST && strcmp(names->texts[i], "others") == 0;
        code = others ? 0 : set_named(show, names->texts[i], as);
    }
    return code;
}

static stp_result make_visibility(scene_show* show)
{
    stp_outline* outline;
    stp_result result = scene_show_outline(show, &outline);
    if (result == STP_OK && show->visibility == NULL) {
        result = stp_visibility_create(show->context, show->store, &show->visibility);
    }
    return result;
}

int scene_show_apply(scene_show* show, const show_options* o, stp_view* view)
{
    const stp_store_directory* directory = stp_store_get_directory(show->store);
    stp_boxd box = directory->root != STP_STORE_NONE ? directory->nodes[directory->root].bounds
                                                     : (stp_boxd){{0, 0, 0}, {0, 0, 0}};
    bool cuts = o->sections.count + o->boxes.count + view->sections.count > 0;
    double size = stp_lengthd(stp_subd(box.max, box.min));
    double rounding = cuts ? stp_bounds_rounding(show->context, show->store) : 0.0;
    int code = add_sections(o, &box, rounding + 1e-6 * size, &view->sections);
    if (code == 0 && cuts) {
        stp_sections_drop_idle(&view->sections, &box, rounding);
    }
    if (code != 0 || o->hide.count + o->isolate.count + o->ghost.count == 0) {
        return code;
    }
    if (make_visibility(show) != STP_OK) {
        return 1;
    }
    bool others = false;
    for (uint32_t i = 0; i < o->ghost.count; ++i) {
        others = others || strcmp(o->ghost.texts[i], "others") == 0;
    }
    if (o->isolate.count > 0 || others) {
        stp_visibility_reset(show->visibility, others ? STP_SHOW_GHOST : STP_SHOW_NOT);
    }
    code = set_all_named(show, &o->isolate, STP_SHOW);
    code = code == 0 ? set_all_named(show, &o->ghost, STP_SHOW_GHOST) : code;
    return code == 0 ? set_all_named(show, &o->hide, STP_SHOW_NOT) : code;
}

stp_result scene_show_viewpoint(scene_show* show, const stp_viewpoint* viewpoint)
{
    bool isolates = false, focuses = false;
    if (viewpoint->object_count == 0) {
        return STP_OK;
    }
    stp_result result = make_visibility(show);
    for (size_t i = 0; i < viewpoint->object_count; ++i) {
        isolates = isolates || viewpoint->objects[i].as == STP_SHOWN_ISOLATED;
        focuses = focuses || viewpoint->objects[i].as == STP_SHOWN_FOCUSED;
    }
    if (result == STP_OK && (isolates || focuses)) {
        stp_visibility_reset(show->visibility, isolates ? STP_SHOW_NOT : STP_SHOW_GHOST);
    }
    for (int pass = 0; pass < 2; ++pass) { // isolates first, because objects within may be hidden
        for (size_t i = 0; i < viewpoint->object_count && result == STP_OK; ++i) {
            const stp_shown_object* object = &viewpoint->objects[i];
            stp_outline_item item;
            bool found = false;
            bool alone = object->as == STP_SHOWN_ISOLATED || object->as == STP_SHOWN_FOCUSED;
            if (alone != (pass == 0)) {
                continue;
            }
            result =
                stp_outline_by_path(show->outline, object->path,
                                    object->has_position ? &object->position : NULL, &item, &found);
            if (result == STP_OK && !found) {
                stp_warn(show->context, "viewpoint %s: there is no object %s", viewpoint->name,
                         object->path);
            }
            if (result == STP_OK && found && item.node != STP_STORE_NONE) {
                result = set_item(show, &item,
                                  alone                           ? STP_SHOW
                                  : object->as == STP_SHOWN_GHOST ? STP_SHOW_GHOST
                                                                  : STP_SHOW_NOT);
            }
        }
    }
    return result;
}

void scene_show_destroy(scene_show* show)
{
    stp_outline_destroy(show->outline);
    stp_visibility_destroy(show->visibility);
    *show = (scene_show){0};
}
