// SPDX-License-Identifier: MIT
#include "program/present/viewpoints.h"

#include "program/present/viewpoints_internal.h"

#include <assert.h>
#include <string.h>

char* stp_viewpoints_path(stp_context* context, const char* model_path)
{
    static const char ending[] = ".views.json";
    const char* slash = strrchr(model_path, '/');
    const char* name = slash != NULL ? slash + 1 : model_path;
    const char* dot = strrchr(name, '.');
    size_t length = dot != NULL && dot != name ? (size_t)(dot - model_path) : strlen(model_path);
    char* path = stp_alloc(context, length + sizeof(ending));
    if (path == NULL) {
        (void)stp_fail_memory(context);
        return NULL;
    }
    memcpy(path, model_path, length);
    memcpy(path + length, ending, sizeof(ending));
    return path;
}

void stp_viewpoint_destroy(stp_context* context, stp_viewpoint* view)
{
    for (size_t i = 0; i < view->object_count; ++i) {
        stp_free(context, view->objects[i].path);
    }
    for (size_t i = 0; i < view->annotation_count; ++i) {
        stp_free(context, view->annotations[i].text);
        stp_free(context, view->annotations[i].object);
    }
    stp_free(context, view->name);
    stp_free(context, view->note);
    stp_free(context, view->objects);
    stp_free(context, view->annotations);
    *view = (stp_viewpoint){0};
}

void stp_viewpoints_destroy(stp_context* context, stp_viewpoints* viewpoints)
{
    for (size_t i = 0; i < viewpoints->count; ++i) {
        stp_viewpoint_destroy(context, &viewpoints->views[i]);
    }
    stp_free(context, viewpoints->views);
    *viewpoints = (stp_viewpoints){0};
}

/// Copies a text that may be NULL. @return false if out of memory (logged)
static bool copy_text(stp_context* context, const char* text, char** copy)
{
    *copy = NULL;
    if (text == NULL) {
        return true;
    }
    size_t size = strlen(text) + 1;
    *copy = stp_alloc(context, size);
    if (*copy == NULL) {
        (void)stp_fail_memory(context);
        return false;
    }
    memcpy(*copy, text, size);
    return true;
}

static bool copy_objects(stp_context* context, const stp_viewpoint* from, stp_viewpoint* to)
{
    to->objects = STP_NEW_ARRAY(context, stp_shown_object, from->object_count + 1);
    bool copied = to->objects != NULL || stp_fail_memory(context) == STP_OK;
    for (size_t i = 0; copied && i < from->object_count; ++i) {
        to->objects[i] = from->objects[i];
        copied = copy_text(context, from->objects[i].path, &to->objects[i].path);
        to->object_count = i + 1;
    }
    return copied;
}

static bool copy_annotations(stp_context* context, const stp_viewpoint* from, stp_viewpoint* to)
{
    to->annotations = STP_NEW_ARRAY(context, stp_annotation, from->annotation_count + 1);
    bool copied = to->annotations != NULL || stp_fail_memory(context) == STP_OK;
    for (size_t i = 0; copied && i < from->annotation_count; ++i) {
        const stp_annotation* annotation = &from->annotations[i];
        to->annotations[i] = (stp_annotation){.point = annotation->point};
        to->annotation_count = i + 1;
        copied = copy_text(context, annotation->text, &to->annotations[i].text) &&
                 copy_text(context, annotation->object, &to->annotations[i].object);
    }
    return copied;
}

static bool copy_viewpoint(stp_context* context, const stp_viewpoint* from, stp_viewpoint* to)
{
    *to = *from;
    to->name = to->note = NULL;
    to->objects = NULL;
    to->annotations = NULL;
    to->object_count = to->annotation_count = 0;
    return copy_text(context, from->name, &to->name) && copy_text(context, from->note, &to->note) &&
           copy_objects(context, from, to) && copy_annotations(context, from, to);
}

stp_result stp_viewpoints_add(stp_context* context, stp_viewpoints* viewpoints,
                              stp_viewpoint* added)
{
    if (viewpoints->count >= STP_VIEWPOINTS_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT, "a file holds at most %d viewpoints",
                        STP_VIEWPOINTS_MAX);
    }
    if (!STP_MAKE_ROOM(context, viewpoints->views, viewpoints->capacity, viewpoints->count + 1)) {
        return stp_fail_memory(context);
    }
    assert(viewpoints->count < viewpoints->capacity);
    assert(stp_viewpoints_find(viewpoints, added->name) == NULL && "names are unique");
    viewpoints->views[viewpoints->count++] = *added;
    return STP_OK;
}

stp_result stp_viewpoints_put(stp_context* context, stp_viewpoints* viewpoints,
                              const stp_viewpoint* viewpoint)
{
    stp_viewpoint copy;
    if (!copy_viewpoint(context, viewpoint, &copy)) {
        stp_viewpoint_destroy(context, &copy);
        return STP_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < viewpoints->count; ++i) {
        if (strcmp(viewpoints->views[i].name, copy.name) == 0) {
            stp_viewpoint_destroy(context, &viewpoints->views[i]);
            viewpoints->views[i] = copy;
            return STP_OK;
        }
    }
    stp_result result = stp_viewpoints_add(context, viewpoints, &copy);
    if (result != STP_OK) {
        stp_viewpoint_destroy(context, &copy);
    }
    return result;
}

bool stp_viewpoints_remove(stp_context* context, stp_viewpoints* viewpoints, const char* name)
{
    for (size_t i = 0; i < viewpoints->count; ++i) {
        if (strcmp(viewpoints->views[i].name, name) == 0) {
            stp_viewpoint_destroy(context, &viewpoints->views[i]);
            viewpoints->count -= 1;
            memmove(&viewpoints->views[i], &viewpoints->views[i + 1],
                    (viewpoints->count - i) * sizeof(*viewpoints->views));
            return true;
        }
    }
    return false;
}

const stp_viewpoint* stp_viewpoints_find(const stp_viewpoints* viewpoints, const char* name)
{
    for (size_t i = 0; i < viewpoints->count; ++i) {
        if (strcmp(viewpoints->views[i].name, name) == 0) {
            return &viewpoints->views[i];
        }
    }
    return NULL;
}

void stp_viewpoint_get_view(const stp_viewpoint* viewpoint, stp_view* view)
{
    view->eye = viewpoint->eye;
    view->target = viewpoint->target;
    view->up = viewpoint->up;
    view->fov_degrees = viewpoint->fov_degrees > 0.0 ? viewpoint->fov_degrees : view->fov_degrees;
    view->ortho_height = viewpoint->ortho_height;
    assert(viewpoint->sections.count <= STP_SECTION_PLANES);
    view->sections = viewpoint->sections;
}
