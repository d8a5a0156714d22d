// SPDX-License-Identifier: MIT
//
// Wavefront OBJ: polygons, points, materials. `o` and `g` become objects (a group is a child of the
// object it was written in; a repeated name continues the earlier one), each `usemtl` within them a
// mesh. Without faces and points, the positions become a point set. The default up axis is y.
#include "import/obj/obj.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <string.h>

#define CHUNK_SIZE ((size_t)1 << 20)

// The end of the first of several file names; names may hold spaces, so ".mtl" and a space end one.
static char* name_end(char* at)
{
    for (; *at != '\0'; ++at) {
        if (at[0] == '.' && (at[1] | 0x20) == 'm' && (at[2] | 0x20) == 't' &&
            (at[3] | 0x20) == 'l') {
            char* end = at + 4 + (at[4] == '"');
            if (*end == ' ' || *end == '\t' || *end == '\0') {
                return end;
            }
        }
    }
    return at;
}

// Some programs write a space within a name as "\\ ".
static void join_escaped(char* names)
{
    char* out = names;
    for (const char* at = names; *at != '\0'; ++at) {
        at += at[0] == '\\' && at[1] == ' ';
        *out++ = *at;
    }
    *out = '\0';
}

static stp_result read_library(stp_obj* obj, char* name)
{
    size_t length = strlen(name);
    if (length >= 2 && name[0] == '"' && name[length - 1] == '"') {
        name[length - 1] = '\0';
        name += 1;
    }
    uint32_t fresh = (uint32_t)obj->libraries.count, known;
    stp_result result = stp_lookup_add(&obj->libraries, name, strlen(name), fresh, &known);
    if (result != STP_OK || known != fresh) {
        return result;
    }
    const char* path;
    result = stp_import_resolve_optional(obj->import, "mtllib", name, &path);
    return result == STP_OK && path != NULL ? stp_mtl_read(obj->import, path, &obj->material_names)
                                            : result;
}

static stp_result read_libraries(stp_obj* obj)
{
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        const stp_obj_event* events = obj->chunks[i].events.items;
        for (size_t k = 0; k < obj->chunks[i].events.count; ++k) {
            if (events[k].kind != STP_OBJ_LIBRARY) {
                continue;
            }
            char names[4097];
            assert(events[k].length < sizeof(names) && "longer names were truncated");
            memcpy(names, events[k].text, events[k].length);
            names[events[k].length] = '\0';
            join_escaped(names);
            for (char* at = names; *at != '\0';) {
                char* end = name_end(at);
                char* next = *end != '\0' ? end + 1 + strspn(end + 1, " \t") : end;
                *end = '\0';
                stp_result result = read_library(obj, at);
                if (result != STP_OK) {
                    return result;
                }
                at = next;
            }
        }
    }
    return STP_OK;
}

static void warn(const stp_obj* obj, size_t count, const char* what)
{
    if (count != 0) {
        stp_warn(obj->context, "%s: %llu %s", obj->import->path, (unsigned long long)count, what);
    }
}

static void warn_of_losses(const stp_obj* obj)
{
    size_t lines = 0, small = 0, curves = 0, bad = 0;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        lines += obj->chunks[i].line_elements;
        small += obj->chunks[i].small_faces;
        curves += obj->chunks[i].curves;
        bad += obj->chunks[i].bad_attributes;
    }
    stp_losses_add(&obj->import->losses, STP_LOSS_LINE, lines);
    stp_losses_add(&obj->import->losses, STP_LOSS_CURVE, curves);
    warn(obj, small, "faces with fewer than three corners are left out");
    warn(obj, bad, "texture coordinates or normals are incomplete and were set to zero");
}

static void destroy(stp_obj* obj)
{
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        stp_obj_free_chunk(obj, &obj->chunks[i]);
    }
    void* whole[] = {obj->positions, obj->colors,   obj->normals, obj->texcoords,
                     obj->corners,   obj->polygons, obj->points};
    for (size_t i = 0; i < sizeof(whole) / sizeof(whole[0]); ++i) {
        stp_obj_free(obj, whole[i]);
    }
    void* arrays[] = {obj->chunks, obj->tail, obj->groups.items, obj->meshes.items,
                      obj->runs.items};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(obj->context, arrays[i]);
    }
    stp_spill_destroy(obj->scratch);
    stp_lookup_destroy(&obj->group_names);
    stp_lookup_destroy(&obj->mesh_keys);
    stp_lookup_destroy(&obj->material_names);
    stp_lookup_destroy(&obj->libraries);
}

stp_result stp_obj_read(stp_import* import, size_t chunk_size)
{
    assert(chunk_size > 0);
    stp_context* context = import->context;
    stp_obj obj = {.import = import,
                   .context = context,
                   .group_names = {.context = context},
                   .mesh_keys = {.context = context},
                   .material_names = {.context = context},
                   .libraries = {.context = context}};
    stp_import_default_axes(import, 'y');
    stp_result result = stp_obj_open_scratch(&obj);
    if (result == STP_OK) {
        result = stp_obj_parse(&obj, chunk_size);
    }
    if (result == STP_OK) {
        warn_of_losses(&obj);
        result = stp_progress(context, "import", 0.5);
    }
    if (result == STP_OK) {
        result = read_libraries(&obj);
    }
    if (result == STP_OK) {
        result = stp_obj_stitch(&obj);
    }
    if (result == STP_OK) {
        result = stp_progress(context, "import", 0.7);
    }
    if (result == STP_OK) {
        result = stp_obj_build(&obj);
    }
    destroy(&obj);
    return result;
}

static stp_result read(stp_import* import)
{
    return stp_obj_read(import, CHUNK_SIZE);
}

const stp_importer stp_importer_obj = {
    .name = "obj", .title = "OBJ", .extensions = "obj", .read = read};
