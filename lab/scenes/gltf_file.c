// SPDX-License-Identifier: MIT
#include "lab/scenes/gltf_plan.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define MOST_FILES 64
#define MOST_BIN_BYTES ((uint64_t)1 << 31)

typedef struct gltf_output {
    gltf_plan plan;
    stp_context* context;
    const char* path;
    char stem[4096];       ///< the path without its suffix
    stp_file_writer* main; ///< the JSON, or the whole .glb
    stp_file_writer* bins[MOST_FILES];
} gltf_output;

static const char* file_name(const char* path)
{
    const char* slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

static bool is_binary(const char* path)
{
    size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".glb") == 0;
}

static stp_result write_vertices(const stp_mesh* mesh, stp_file_writer* file)
{
    size_t size = 12 * (size_t)mesh->vertex_count;
    stp_result result = stp_file_writer_append(file, mesh->positions, size);
    if (result == STP_OK && mesh->normals != NULL) {
        result = stp_file_writer_append(file, mesh->normals, size);
    }
    return result;
}

static stp_result write_indices(const stp_mesh* mesh, uint32_t index_bytes, stp_file_writer* file)
{
    size_t count = 3 * (size_t)mesh->triangle_count;
    if (index_bytes == 4) {
        return stp_file_writer_append(file, mesh->indices, 4 * count);
    }
    stp_result result = STP_OK;
    uint16_t block[4096];
    size_t filled = 0;
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        block[filled++] = (uint16_t)mesh->indices[i];
        bool last = i + 1 == count;
        if (last && count % 2 == 1) {
            block[filled++] = 0; // pads to a multiple of four bytes
        }
        if (last || filled == 4096) {
            result = stp_file_writer_append(file, block, 2 * filled);
            filled = 0;
        }
    }
    return result;
}

static stp_result write_mesh(const gltf_output* o, size_t index, gltf_region region,
                             stp_file_writer* file)
{
    const stp_mesh* mesh = &o->plan.scene->meshes[index];
    switch (region) {
    case GLTF_VERTICES:
        return write_vertices(mesh, file);
    case GLTF_COLORS:
        return mesh->colors == NULL
                   ? STP_OK
                   : stp_file_writer_append(file, mesh->colors, 8 * (size_t)mesh->vertex_count);
    default:
        return write_indices(mesh, o->plan.meshes[index].index_bytes, file);
    }
}

// Writes one column of all instances: translations, rotations or scales.
static stp_result write_instances(const gltf_output* o, int column, stp_file_writer* file)
{
    const stp_scene* scene = o->plan.scene;
    stp_result result = STP_OK;
    for (size_t i = 0; result == STP_OK && i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        bool listed = o->plan.instance_accessor[i] != STP_NONE;
        for (uint32_t k = 0; result == STP_OK && listed && k < object->instance_count; ++k) {
            float values[3][4];
            (void)gltf_decompose(&scene->instances[object->first_instance + k], values[0],
                                 values[1], values[2]);
            result =
                stp_file_writer_append(file, values[column], (column == 1 ? 4 : 3) * sizeof(float));
        }
    }
    return result;
}

static stp_result write_buffer(const gltf_output* o, size_t buffer, stp_file_writer* file)
{
    size_t mesh_count = o->plan.scene->mesh_count;
    stp_result result = STP_OK;
    for (int region = 0; region < GLTF_REGIONS; ++region) {
        for (size_t i = 0; result == STP_OK && i < mesh_count; ++i) {
            if (o->plan.meshes[i].buffer == buffer) {
                result = write_mesh(o, i, (gltf_region)region, file);
            }
            if (result == STP_OK && i % 256 == 0) {
                double step = (double)i / (double)mesh_count;
                double part = ((double)region + step) / GLTF_REGIONS;
                result = stp_progress(o->context, "write",
                                      ((double)buffer + part) / (double)o->plan.buffer_count);
            }
        }
    }
    bool last = buffer + 1 == o->plan.buffer_count && o->plan.instance_count > 0;
    for (int column = 0; result == STP_OK && last && column < 3; ++column) {
        result = write_instances(o, column, file);
    }
    return result;
}

static void put_u32(unsigned char* out, uint64_t value)
{
    for (int i = 0; i < 4; ++i) {
        out[i] = (unsigned char)(value >> (8 * i));
    }
}

// Header, JSON, one buffer. The lengths are filled in at the end.
static stp_result write_glb(gltf_output* o)
{
    unsigned char head[28] = {'g', 'l', 'T', 'F', 2};
    memcpy(head + 16, "JSON", 4);
    uint64_t bin = gltf_buffer_bytes(&o->plan, 0);
    stp_result result = stp_file_writer_append(o->main, head, 20);
    result = result == STP_OK ? gltf_json_write(&o->plan, NULL, o->main) : result;
    if (result != STP_OK) {
        return result;
    }
    size_t padding = (size_t)(-stp_file_writer_size(o->main) & 3);
    result = stp_file_writer_append(o->main, "   ", padding);
    uint64_t json = stp_file_writer_size(o->main) - 20;
    uint64_t total = 20 + json + (bin > 0 ? 8 + bin : 0);
    if (result == STP_OK && (bin > UINT32_MAX || total > UINT32_MAX)) {
        return stp_fail(o->context, STP_ERROR_LIMIT,
                        "%s: %llu bytes exceed the limit of .glb; use a .gltf file", o->path,
                        (unsigned long long)total);
    }
    put_u32(head + 8, total);
    put_u32(head + 12, json);
    put_u32(head + 20, bin);
    memcpy(head + 24, "BIN", 4);
    result = result == STP_OK ? stp_file_writer_patch(o->main, 0, head, 20) : result;
    if (result == STP_OK && bin > 0) {
        result = stp_file_writer_append(o->main, head + 20, 8);
        result = result == STP_OK ? write_buffer(o, 0, o->main) : result;
    }
    return result;
}

static stp_result write_files(gltf_output* o)
{
    stp_result result = gltf_json_write(&o->plan, file_name(o->stem), o->main);
    if (o->plan.buffer_count > MOST_FILES) {
        return stp_fail(o->context, STP_ERROR_LIMIT, "%s: the scene needs %zu binary files",
                        o->path, o->plan.buffer_count);
    }
    for (size_t i = 0; result == STP_OK && i < o->plan.buffer_count; ++i) {
        char path[4400];
        gltf_buffer_name(path, sizeof(path), o->stem, i);
        if (gltf_buffer_bytes(&o->plan, i) > 0) {
            result = stp_file_writer_open(o->context, path, &o->bins[i]);
            result = result == STP_OK ? write_buffer(o, i, o->bins[i]) : result;
            assert(result != STP_OK ||
                   stp_file_writer_size(o->bins[i]) == gltf_buffer_bytes(&o->plan, i));
        }
    }
    return result;
}

// Commits or aborts all files. The JSON comes last, so the files it refers to exist.
static stp_result close_files(gltf_output* o, stp_result result, gltf_figures* figures)
{
    stp_file_writer* writers[MOST_FILES + 1];
    memcpy(writers, o->bins, sizeof(o->bins));
    writers[MOST_FILES] = o->main;
    for (int i = 0; i <= MOST_FILES; ++i) {
        if (writers[i] == NULL) {
            continue;
        }
        figures->files += 1;
        figures->bytes += stp_file_writer_size(writers[i]);
        if (result == STP_OK) {
            result = stp_file_writer_commit(writers[i]);
        } else {
            stp_file_writer_abort(writers[i]);
        }
    }
    return result;
}

stp_result gltf_file_write(const stp_scene* scene, const char* path, gltf_figures* figures)
{
    gltf_figures unwanted;
    figures = figures != NULL ? figures : &unwanted;
    *figures = (gltf_figures){0};
    bool binary = is_binary(path);
    gltf_output o = {.context = scene->context, .path = path};
    const char* name = file_name(path);
    const char* dot = strrchr(name, '.');
    size_t stem = dot != NULL && dot != name ? (size_t)(dot - path) : strlen(path);
    if (stem >= sizeof(o.stem)) {
        return stp_fail(o.context, STP_ERROR_ARGUMENT, "%s: the path is too long", path);
    }
    memcpy(o.stem, path, stem);
    stp_result result = gltf_plan_make(scene, binary ? UINT64_MAX : MOST_BIN_BYTES, path, &o.plan);
    if (result != STP_OK) {
        return result;
    }
    result = stp_file_writer_open(o.context, path, &o.main);
    if (result == STP_OK) {
        result = close_files(&o, binary ? write_glb(&o) : write_files(&o), figures);
    }
    figures->nodes = o.plan.node_count;
    figures->meshes = scene->mesh_count;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        figures->triangles += scene->meshes[i].triangle_count;
    }
    gltf_plan_destroy(&o.plan);
    return result;
}
