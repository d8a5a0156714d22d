// SPDX-License-Identifier: MIT
#include "base/math/color.h"
#include "embed/measuring.h"
#include "program/reports/describe.h"
#include "program/reports/reports.h"
#include "select/pick_ray.h"
#include "store/file/point_attributes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_ROOM = 4096 };
static const double snap_pixels = 8.0, point_pixels = 2.0;

bool pick_read_place(const char* text, double place[2])
{
    char* end;
    place[0] = strtod(text, &end);
    if (end == text || *end != ',') {
        return false;
    }
    text = end + 1;
    place[1] = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(place[0]) && isfinite(place[1]);
}

static json_t* pack_vector(stp_vec3d v)
{
    return json_pack("[f,f,f]", v.x, v.y, v.z);
}

static json_t* describe_object(scene_show* show, const stp_pick* pick)
{
    stp_outline* outline;
    stp_outline_item item;
    stp_outline_row row;
    char path[PATH_ROOM];
    if (scene_show_outline(show, &outline) != STP_OK ||
        stp_outline_find(outline, pick->part, &pick->holder.transform, &item) != STP_OK ||
        stp_outline_describe(outline, &item, &row) != STP_OK ||
        stp_outline_path(outline, &item, path, sizeof(path)) != STP_OK) {
        return NULL;
    }
    if (item.depth == 0) {
        return json_null();
    }
    return json_pack("{s:I, s:o, s:o, s:o, s:I, s:I, s:{s:o, s:o}}", "index",
                     (json_int_t)item.objects[item.depth - 1], "name", describe_json_text(row.name),
                     "path", describe_json_text(path), "id", describe_json_text(row.id),
                     "triangles", (json_int_t)row.triangle_count, "points",
                     (json_int_t)row.point_count, "bounds", "min", pack_vector(row.bounds.min),
                     "max", pack_vector(row.bounds.max));
}

/// The attributes of a point, by name; NULL if they cannot be read (logged) or memory runs out.
static json_t* describe_attributes(stp_store* store, const stp_pick* pick)
{
    uint32_t mask = stp_store_point_attributes(store, pick->part.index);
    json_t* json = json_object();
    for (uint32_t a = 0; a < STP_ATTRIBUTES && json != NULL; ++a) {
        stp_attribute attribute = (stp_attribute)a;
        double value; // room for one of any type
        if ((mask & stp_attribute_bit(attribute)) == 0) {
            continue;
        }
        if (stp_store_get_point_values(store, pick->part.index, attribute, pick->element, 1,
                                       &value) != STP_OK) {
            json_decref(json);
            return NULL;
        }
        double number = stp_attribute_number(attribute, &value, 0);
        (void)json_object_set_new(
            json, stp_attribute_name(attribute),
            attribute == STP_ATTRIBUTE_TIME ? json_real(number) : json_integer((json_int_t)number));
        if (attribute == STP_ATTRIBUTE_CLASS) {
            (void)json_object_set_new(json, "class name",
                                      describe_json_text(stp_class_name((uint32_t)number)));
        }
    }
    return json;
}

static json_t* describe_hit(scene_show* show, const stp_view* view, const stp_pick* pick)
{
    static const char* const snaps[] = {"none", "vertex", "edge"};
    const stp_store_directory* d = stp_store_get_directory(show->store);
    stp_measuring measuring = {.unit_metres = d->unit_metres, .up = d->up};
    stp_vec3d snapped;
    double base, slope;
    stp_pixel_width(view, &base, &slope);
    stp_snap_kind snap =
        stp_pick_snap(pick, snap_pixels * (base + slope * pick->distance), &snapped);
    assert((size_t)snap < sizeof(snaps) / sizeof(snaps[0]) && "every kind has a name");
    json_t* object = describe_object(show, pick);
    if (object == NULL) {
        return NULL;
    }
    bool is_mesh = pick->part.kind == STP_STORE_PART_MESH;
    json_t* json = json_pack(
        "{s:b, s:f, s:o, s:o, s:s, s:o, s:o, s:s, s:I, s:I, s:I, s:o, s:{s:s, s:o}}", "hit", 1,
        "distance", pick->distance, "position", pack_vector(pick->position), "coordinates",
        pack_vector(stp_measure_coordinates(&measuring, pick->position)), "unit",
        stp_measure_unit(&measuring), "normal", pack_vector(pick->normal), "object", object, "kind",
        is_mesh ? "triangle" : "point", "part", (json_int_t)pick->part.index, "element",
        (json_int_t)pick->element, "node", (json_int_t)pick->holder.node, "material",
        describe_json_text(d->materials[pick->material].name), "snap", "kind", snaps[snap],
        "position", pack_vector(snapped));
    (void)json_object_set_new(json, "coordinate_system",
                              describe_json_text(stp_store_coordinate_system(show->store)));
    json_t* attributes = is_mesh ? NULL : describe_attributes(show->store, pick);
    if (!is_mesh && json_object_set_new(json, "attributes", attributes) != 0) {
        json_decref(json);
        return NULL;
    }
    return json;
}

json_t* pick_describe(scene_show* show, const stp_view* view, bool back_faces,
                      const double place[2])
{
    stp_pick_desc desc = {
        .sections = &view->sections, .visibility = show->visibility, .back_faces = back_faces};
    stp_pick pick;
    double base, slope;
    stp_pixel_width(view, &base, &slope);
    desc.point_base = point_pixels * base;
    desc.point_slope = point_pixels * slope;
    if (!stp_ray_of_pixel(view, place[0], place[1], &desc.ray)) {
        (void)tool_error("the view is invalid");
        return NULL;
    }
    if (stp_pick_ray(show->context, show->store, &desc, &pick) != STP_OK) {
        return NULL;
    }
    json_t* json = pick.hit ? describe_hit(show, view, &pick) : json_pack("{s:b}", "hit", 0);
    if (json != NULL && pick.incomplete) {
        (void)json_object_set_new(json, "incomplete", json_true());
    }
    return json;
}
