// SPDX-License-Identifier: MIT
// Writes the sidecar file, and reads it from disk.
#include "base/io/file.h"
#include "program/present/viewpoints_internal.h"

#include <assert.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

stp_result stp_viewpoints_read(stp_context* context, const char* path, stp_viewpoints* viewpoints)
{
    stp_mapped_file file;
    *viewpoints = (stp_viewpoints){0};
    if (access(path, F_OK) != 0) {
        return STP_OK;
    }
    stp_result result = stp_file_map(context, path, &file);
    if (result == STP_OK) {
        result = stp_viewpoints_parse(context, path, file.bytes, file.size, viewpoints);
        stp_file_unmap(&file);
    }
    return result;
}

static json_t* pack_vector(stp_vec3d v)
{
    return json_pack("[f,f,f]", v.x, v.y, v.z);
}

static json_t* pack_objects(const stp_viewpoint* view, stp_shown_as as)
{
    json_t* list = json_array();
    bool good = list != NULL;
    for (size_t i = 0; good && i < view->object_count; ++i) {
        const stp_shown_object* object = &view->objects[i];
        if (object->as != as) {
            continue;
        }
        json_t* json = json_pack("{s:s}", "path", object->path);
        good = json_array_append_new(list, json) == 0;
        if (good && object->has_position) {
            good = json_object_set_new(json, "at", pack_vector(object->position)) == 0;
        }
    }
    if (!good) {
        json_decref(list);
        return NULL;
    }
    return list;
}

static json_t* pack_sections(const stp_sections* sections)
{
    assert(sections->count <= STP_SECTION_PLANES && "a reader accepts no more");
    json_t* list = json_array();
    for (uint32_t i = 0; list != NULL && i < sections->count; ++i) {
        const stp_section_plane* p = &sections->planes[i];
        if (json_array_append_new(list, json_pack("[f,f,f,f]", p->normal.x, p->normal.y,
                                                  p->normal.z, p->distance)) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

static json_t* pack_annotations(const stp_viewpoint* view)
{
    json_t* list = json_array();
    for (size_t i = 0; list != NULL && i < view->annotation_count; ++i) {
        const stp_annotation* a = &view->annotations[i];
        if (json_array_append_new(list, json_pack("{s:s, s:o, s:s*}", "text", a->text, "at",
                                                  pack_vector(a->point), "object", a->object)) !=
            0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

/// Sets a list unless it is empty. @return false if out of memory
static bool set_list(json_t* object, const char* member, json_t* list)
{
    if (list != NULL && json_array_size(list) == 0) {
        json_decref(list);
        return true;
    }
    return json_object_set_new(object, member, list) == 0;
}

static json_t* pack_view(const stp_viewpoint* view)
{
    json_t* json = json_pack("{s:s, s:s*, s:o, s:o, s:o}", "name", view->name, "note", view->note,
                             "eye", pack_vector(view->eye), "target", pack_vector(view->target),
                             "up", pack_vector(view->up));
    bool good = json != NULL;
    if (good && view->fov_degrees > 0.0) {
        good = json_object_set_new(json, "fov", json_real(view->fov_degrees)) == 0;
    }
    if (good && view->ortho_height > 0.0) {
        good = json_object_set_new(json, "ortho_height", json_real(view->ortho_height)) == 0;
    }
    good = good && set_list(json, "sections", pack_sections(&view->sections));
    for (int as = 0; good && as < STP_SHOWN_KINDS; ++as) {
        good = set_list(json, stp_viewpoint_lists[as], pack_objects(view, (stp_shown_as)as));
    }
    good = good && set_list(json, "annotations", pack_annotations(view));
    if (!good) {
        json_decref(json);
        return NULL;
    }
    return json;
}

static json_t* pack_all(const stp_viewpoints* viewpoints)
{
    json_t* list = json_array();
    bool good = list != NULL;
    for (size_t i = 0; good && i < viewpoints->count; ++i) {
        good = json_array_append_new(list, pack_view(&viewpoints->views[i])) == 0;
    }
    if (!good) {
        json_decref(list);
        return NULL;
    }
    return json_pack("{s:i, s:o}", "version", 1, "views", list);
}

stp_result stp_viewpoints_write(stp_context* context, const char* path,
                                const stp_viewpoints* viewpoints)
{
    json_t* root = pack_all(viewpoints);
    char* text = root != NULL ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    if (text == NULL) { // also if a text is not valid UTF-8, which no reader would accept
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "%s: cannot write the viewpoints as JSON: texts must be UTF-8", path);
    }
    stp_file_writer* writer;
    size_t size = strlen(text);
    stp_result result =
        size < STP_VIEWPOINTS_BYTES_MAX // a line end follows
            ? stp_file_writer_open(context, path, &writer)
            : stp_fail(context, STP_ERROR_LIMIT, "%s: the viewpoints file would exceed %zu bytes",
                       path, STP_VIEWPOINTS_BYTES_MAX);
    if (result == STP_OK) {
        result = stp_file_writer_append(writer, text, size);
        result = result == STP_OK ? stp_file_writer_append(writer, "\n", 1) : result;
        if (result == STP_OK) {
            result = stp_file_writer_commit(writer);
        } else {
            stp_file_writer_abort(writer);
        }
    }
    free(text);
    return result;
}
