// SPDX-License-Identifier: MIT
// Reads the sidecar file. Every member is validated; unknown members are ignored.
#include "base/io/file.h"
#include "base/math/math.h"
#include "program/present/viewpoints_internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static const double max_coordinate = 1e18, min_height = 1e-18;

typedef struct reader {
    stp_context* context;
    const char* name;
    size_t view; ///< index of the current view
} reader;

static stp_result fail_member(const reader* r, const char* member, const char* expected)
{
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: view %zu: \"%s\" must be %s", r->name,
                    r->view, member, expected);
}

static stp_result read_vector(const reader* r, const json_t* from, const char* member,
                              stp_vec3d* vector)
{
    double v[3] = {0};
    if (!stp_json_numbers(json_object_get(from, member), 3, max_coordinate, v)) {
        return fail_member(r, member, "three numbers");
    }
    *vector = (stp_vec3d){v[0], v[1], v[2]};
    return STP_OK;
}

/// Reads an optional number from `low` to `high` (default 0).
static stp_result read_number(const reader* r, const json_t* from, const char* member, double low,
                              double high, double* number)
{
    const json_t* json = json_object_get(from, member);
    *number = json_number_value(json);
    if (json != NULL && (!json_is_number(json) || !(*number >= low && *number <= high))) {
        char expected[80];
        snprintf(expected, sizeof(expected), "a number from %.15g to %.15g", low, high);
        return fail_member(r, member, expected);
    }
    return STP_OK;
}

/// Reads a text; NULL if it is optional and missing.
static stp_result read_text(const reader* r, const json_t* from, const char* member, bool needed,
                            char** text)
{
    const json_t* json = json_object_get(from, member);
    *text = NULL;
    if (json == NULL && !needed) {
        return STP_OK;
    }
    size_t length = json_string_length(json);
    if (!json_is_string(json) || (needed && length == 0) || length > STP_VIEWPOINT_TEXT_MAX) {
        return fail_member(r, member, "a text of at most 65536 bytes");
    }
    *text = stp_alloc(r->context, length + 1);
    if (*text == NULL) {
        return stp_fail_memory(r->context);
    }
    memcpy(*text, json_string_value(json), length + 1);
    return STP_OK;
}

static stp_result read_sections(const reader* r, const json_t* from, stp_sections* sections)
{
    const json_t* list = json_object_get(from, "sections");
    size_t count = json_array_size(list);
    if (list != NULL && (!json_is_array(list) || count > STP_SECTION_PLANES)) {
        return fail_member(r, "sections", "an array of at most 14 planes");
    }
    for (size_t i = 0; i < count; ++i) {
        double p[4];
        stp_section_plane* plane = &sections->planes[i];
        if (!stp_json_numbers(json_array_get(list, i), 4, max_coordinate, p) ||
            !(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] > 1e-12)) {
            return fail_member(r, "sections", "planes: a normal of length 1, and its distance");
        }
        *plane = (stp_section_plane){.normal = {p[0], p[1], p[2]}, .distance = p[3]};
    }
    sections->count = (uint32_t)count;
    return STP_OK;
}

static stp_result read_objects(const reader* r, const json_t* from, stp_shown_as as,
                               stp_viewpoint* view)
{
    const char* member = stp_viewpoint_lists[as];
    const json_t* list = json_object_get(from, member);
    if (list != NULL && !json_is_array(list)) {
        return fail_member(r, member, "an array of objects");
    }
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t* json = json_array_get(list, i);
        stp_shown_object* object = &view->objects[view->object_count];
        *object = (stp_shown_object){.as = as};
        stp_result result = read_text(r, json, "path", true, &object->path);
        if (result == STP_OK && json_object_get(json, "at") != NULL) {
            object->has_position = true;
            result = read_vector(r, json, "at", &object->position);
        }
        view->object_count += 1;
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

static stp_result read_all_objects(const reader* r, const json_t* from, stp_viewpoint* view)
{
    size_t count = 1;
    for (int as = 0; as < STP_SHOWN_KINDS; ++as) {
        count += json_array_size(json_object_get(from, stp_viewpoint_lists[as]));
    }
    view->objects = STP_NEW_ARRAY(r->context, stp_shown_object, count);
    stp_result result = view->objects != NULL ? STP_OK : stp_fail_memory(r->context);
    for (int as = 0; as < STP_SHOWN_KINDS && result == STP_OK; ++as) {
        result = read_objects(r, from, (stp_shown_as)as, view);
    }
    assert((result != STP_OK || view->object_count + 1 == count) && "all lists fit");
    return result;
}

static stp_result read_annotations(const reader* r, const json_t* from, stp_viewpoint* view)
{
    const json_t* list = json_object_get(from, "annotations");
    size_t count = json_array_size(list);
    if (list != NULL && !json_is_array(list)) {
        return fail_member(r, "annotations", "an array");
    }
    view->annotations = STP_NEW_ARRAY(r->context, stp_annotation, count + 1);
    stp_result result = view->annotations != NULL ? STP_OK : stp_fail_memory(r->context);
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        const json_t* json = json_array_get(list, i);
        stp_annotation* annotation = &view->annotations[i];
        *annotation = (stp_annotation){0};
        view->annotation_count = i + 1;
        result = read_text(r, json, "text", true, &annotation->text);
        result =
            result == STP_OK ? read_text(r, json, "object", false, &annotation->object) : result;
        result = result == STP_OK ? read_vector(r, json, "at", &annotation->point) : result;
    }
    return result;
}

static stp_result read_camera(const reader* r, const json_t* from, stp_viewpoint* view)
{
    stp_result result = read_vector(r, from, "eye", &view->eye);
    result = result == STP_OK ? read_vector(r, from, "target", &view->target) : result;
    view->up = (stp_vec3d){0, 1, 0};
    if (result == STP_OK && json_object_get(from, "up") != NULL) {
        result = read_vector(r, from, "up", &view->up);
    }
    result = result == STP_OK ? read_number(r, from, "fov", STP_FOV_DEGREES_MIN,
                                            STP_FOV_DEGREES_MAX, &view->fov_degrees)
                              : result;
    result = result == STP_OK ? read_number(r, from, "ortho_height", min_height, max_coordinate,
                                            &view->ortho_height)
                              : result;
    stp_vec3d gaze = stp_subd(view->target, view->eye);
    if (result == STP_OK && !(stp_dotd(gaze, gaze) > 0.0)) {
        return fail_member(r, "target", "different from \"eye\"");
    }
    return result;
}

static stp_result read_view(const reader* r, const json_t* from, stp_viewpoint* view)
{
    if (!json_is_object(from)) {
        return stp_fail(r->context, STP_ERROR_FORMAT, "%s: view %zu is not an object", r->name,
                        r->view);
    }
    stp_result result = read_text(r, from, "name", true, &view->name);
    result = result == STP_OK ? read_text(r, from, "note", false, &view->note) : result;
    result = result == STP_OK ? read_camera(r, from, view) : result;
    result = result == STP_OK ? read_sections(r, from, &view->sections) : result;
    result = result == STP_OK ? read_all_objects(r, from, view) : result;
    return result == STP_OK ? read_annotations(r, from, view) : result;
}

static stp_result read_root(reader* r, const json_t* root, stp_viewpoints* viewpoints)
{
    const json_t* list = json_object_get(root, "views");
    const json_t* version = json_object_get(root, "version");
    if (!json_is_array(list) || json_array_size(list) > STP_VIEWPOINTS_MAX) {
        return stp_fail(r->context, STP_ERROR_FORMAT,
                        "%s: \"views\" must be an array of at most %d views", r->name,
                        STP_VIEWPOINTS_MAX);
    }
    if (version != NULL && json_integer_value(version) != 1) {
        return stp_fail(r->context, STP_ERROR_VERSION, "%s: \"version\" must be 1", r->name);
    }
    for (r->view = 0; r->view < json_array_size(list); ++r->view) {
        stp_viewpoint view = {0};
        stp_result result = read_view(r, json_array_get(list, r->view), &view);
        if (result == STP_OK && stp_viewpoints_find(viewpoints, view.name) != NULL) {
            result = fail_member(r, "name", "unique");
        }
        result = result == STP_OK ? stp_viewpoints_add(r->context, viewpoints, &view) : result;
        if (result != STP_OK) {
            stp_viewpoint_destroy(r->context, &view);
            return result;
        }
    }
    return STP_OK;
}

stp_result stp_viewpoints_parse(stp_context* context, const char* name, const unsigned char* bytes,
                                size_t size, stp_viewpoints* viewpoints)
{
    *viewpoints = (stp_viewpoints){0};
    stp_json_text text = {name, "a viewpoints file", bytes, size, STP_VIEWPOINTS_BYTES_MAX};
    json_t* root;
    stp_result result = stp_json_parse(context, &text, &root);
    if (result != STP_OK) {
        return result;
    }
    reader r = {.context = context, .name = name};
    result = read_root(&r, root, viewpoints);
    stp_json_release(context, &text, root);
    if (result != STP_OK) {
        stp_viewpoints_destroy(context, viewpoints);
    }
    return result;
}
