// SPDX-License-Identifier: MIT
#include "program/files/point_file.h"

#include "base/io/bytes.h"
#include "base/io/file.h"
#include "base/math/math.h"
#include "program/files/overwrite.h"
#include "program/files/scene_file.h"
#include "program/options/tool.h"
#include "scene/bulk.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum {
    STRIPE = 1 << 20, ///< pages of mapped files are released after this many points
    MEMORY_SHARE = 4, ///< reciprocal share of the usable memory: larger point sets go to a file
    SMALL_SHARE = 16, ///< reciprocal share of the limit: smaller files are not spilled
};

// One part of the scene.
typedef struct part_points {
    uint32_t count;
    const float* positions;
    const float* normals;
    const uint8_t* colors;
} part_points;

static part_points find_points(const stp_scene* scene, stp_part part)
{
    if (part.kind == STP_PART_MESH) {
        const stp_mesh* mesh = &scene->meshes[part.index];
        return (part_points){mesh->vertex_count, mesh->positions, mesh->normals, NULL};
    }
    const stp_point_set* set = &scene->point_sets[part.index];
    return (part_points){set->point_count, set->positions, set->normals, set->colors};
}

stp_vec3d tool_own_axes(char up, stp_vec3d p)
{
    return up == 'z' ? (stp_vec3d){p.x, -p.z, p.y} : p;
}

stp_vec3d tool_scene_axes(char up, stp_vec3d p)
{
    return up == 'z' ? (stp_vec3d){p.x, p.z, -p.y} : p;
}

static void release_pages(const stp_scene* scene, const tool_points* points)
{
    if (points->spilled) {
        stp_spill_release_pages(points->spill);
    }
    if (scene->spill != NULL) {
        stp_spill_release_pages(scene->spill);
    }
}

static void copy_part(const stp_scene* scene, const stp_placed_part* placed, tool_points* points,
                      uint32_t first)
{
    part_points part = find_points(scene, placed->part);
    assert((uint64_t)first + part.count <= points->count);
    double turn[3][3];
    stp_affine_normal_matrix(&placed->transform, turn);
    for (uint32_t i = 0; i < part.count; ++i) {
        if (i % STRIPE == 0) {
            release_pages(scene, points);
        }
        size_t from = 3 * (size_t)i, to = 3 * ((size_t)first + i);
        stp_vec3d p = {(double)part.positions[from], (double)part.positions[from + 1],
                       (double)part.positions[from + 2]};
        p = tool_own_axes(points->up, stp_affine_point(&placed->transform, p));
        points->positions[to] = (float)(p.x - points->origin[0]);
        points->positions[to + 1] = (float)(p.y - points->origin[1]);
        points->positions[to + 2] = (float)(p.z - points->origin[2]);
        if (points->normals != NULL) {
            stp_vec3d n = {0};
            if (part.normals != NULL) {
                const float* m = part.normals + from;
                double v[3];
                for (int r = 0; r < 3; ++r) {
                    v[r] = turn[r][0] * (double)m[0] + turn[r][1] * (double)m[1] +
                           turn[r][2] * (double)m[2];
                }
                n = tool_own_axes(points->up, stp_normalized((stp_vec3d){v[0], v[1], v[2]}));
            }
            points->normals[to] = (float)n.x;
            points->normals[to + 1] = (float)n.y;
            points->normals[to + 2] = (float)n.z;
        }
        if (points->colors != NULL) {
            static const uint8_t white[4] = {255, 255, 255, 255};
            memcpy(points->colors + 4 * ((size_t)first + i),
                   part.colors != NULL ? part.colors + 4 * (size_t)i : white, 4);
        }
    }
}

/// Allocates room for the points: in memory if they are a small share of the limit, else in a file.
static stp_result make_arrays(stp_context* context, bool normals, bool colors, tool_points* points)
{
    size_t count = points->count, floats = 3 * sizeof(float) * count;
    stp_bulk_array arrays[3] = {
        {.size = floats}, {.size = normals ? floats : 0}, {.size = colors ? 4 * count : 0}};
    uint64_t size = (uint64_t)arrays[0].size + arrays[1].size + arrays[2].size;
    points->spilled =
        points->spill != NULL && size > stp_usable_memory(stp_memory_limit(context)) / MEMORY_SHARE;
    bool made = true;
    if (points->spilled) {
        stp_result result = stp_bulk_alloc_spilled(points->spill, arrays, 3);
        if (result != STP_OK) {
            return result;
        }
    }
    for (int i = 0; i < 3 && !points->spilled; ++i) {
        arrays[i].bytes = arrays[i].size > 0 ? stp_alloc(context, arrays[i].size) : NULL;
        made = made && (arrays[i].size == 0 || arrays[i].bytes != NULL);
    }
    points->positions = arrays[0].bytes;
    points->normals = arrays[1].bytes;
    points->colors = arrays[2].bytes;
    return made ? STP_OK : stp_fail_memory(context);
}

static stp_result copy_parts(const stp_scene* scene, const char* path, const stp_placed_part* parts,
                             size_t part_count, const double* origin, tool_points* points)
{
    stp_context* context = scene->context;
    uint64_t count = 0;
    bool normals = false, colors = false;
    for (size_t i = 0; i < part_count; ++i) {
        part_points part = find_points(scene, parts[i].part);
        count += part.count;
        normals = normals || part.normals != NULL;
        colors = colors || part.colors != NULL;
    }
    if (count == 0 || count > UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "%s: expected between 1 and 2^32 - 1 points, found %llu", path,
                        (unsigned long long)count);
    }
    points->count = (uint32_t)count;
    points->up = scene->up != NULL ? scene->up[0] : 'y';
    stp_vec3d shift = {parts[0].transform.m[0][3], parts[0].transform.m[1][3],
                       parts[0].transform.m[2][3]};
    shift = tool_own_axes(points->up, shift);
    memcpy(points->origin, origin != NULL ? origin : (double[3]){shift.x, shift.y, shift.z},
           sizeof(points->origin));
    stp_result result = make_arrays(context, normals, colors, points);
    if (result != STP_OK) {
        return result;
    }
    uint32_t first = 0;
    for (size_t i = 0; i < part_count; ++i) {
        copy_part(scene, &parts[i], points, first);
        first += find_points(scene, parts[i].part).count;
    }
    assert(first == points->count && "all points were copied");
    return STP_OK;
}

// Mirrored parts get swapped corners, so that triangles still face outwards.
static uint32_t copy_part_triangles(const stp_mesh* mesh, const stp_affine* transform,
                                    uint32_t first, uint32_t* to)
{
    bool mirrored = stp_affine_determinant(transform) < 0.0;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i += 3) {
        to[i] = first + mesh->indices[i];
        to[i + 1] = first + mesh->indices[i + (mirrored ? 2 : 1)];
        to[i + 2] = first + mesh->indices[i + (mirrored ? 1 : 2)];
    }
    return mesh->triangle_count;
}

static stp_result copy_triangles(const stp_scene* scene, const char* path,
                                 const stp_placed_part* parts, size_t part_count,
                                 tool_points* points)
{
    uint64_t count = 0;
    for (size_t i = 0; i < part_count; ++i) {
        bool is_mesh = parts[i].part.kind == STP_PART_MESH;
        count += is_mesh ? scene->meshes[parts[i].part.index].triangle_count : 0;
    }
    if (count > UINT32_MAX) {
        return stp_fail(scene->context, STP_ERROR_LIMIT,
                        "%s: expected at most 2^32 - 1 triangles, found %llu", path,
                        (unsigned long long)count);
    }
    if (count == 0) {
        return STP_OK;
    }
    points->triangles = STP_NEW_ARRAY(scene->context, uint32_t, 3 * count);
    if (points->triangles == NULL) {
        return stp_fail_memory(scene->context);
    }
    uint32_t first = 0;
    for (size_t i = 0; i < part_count; ++i) {
        if (parts[i].part.kind == STP_PART_MESH) {
            points->triangle_count +=
                copy_part_triangles(&scene->meshes[parts[i].part.index], &parts[i].transform, first,
                                    points->triangles + 3 * (size_t)points->triangle_count);
        }
        first += find_points(scene, parts[i].part).count;
    }
    assert(first == points->count && points->triangle_count == count);
    return STP_OK;
}

stp_result tool_points_open_spill(stp_context* context, const char* output, tool_points* points)
{
    if (points->spill != NULL) {
        return STP_OK;
    }
    const char* slash = strrchr(output, '/');
    size_t length = slash != NULL ? (size_t)(slash - output) + 1 : 0; // with the slash
    char* folder = stp_alloc(context, length + 2);
    if (folder == NULL) {
        return stp_fail_memory(context);
    }
    memcpy(folder, length > 0 ? output : ".", length > 0 ? length : 1);
    folder[length > 0 ? length : 1] = '\0';
    stp_result result = stp_spill_create(context, folder, &points->spill);
    stp_free(context, folder);
    return result;
}

/// Whether a model may be too large for memory.
static bool may_be_large(const stp_context* context, const char* path)
{
    uint64_t limit = stp_memory_limit(context);
    struct stat status;
    return limit != 0 || stat(path, &status) != 0 || // a scene that is made
           (uint64_t)status.st_size > stp_usable_memory(limit) / SMALL_SHARE;
}

/// @param beside a path in the folder for spill files; NULL: no spilling
static stp_result read_file(stp_context* context, const char* path, const double* origin,
                            bool triangles, const char* beside, tool_points* points)
{
    *points = (tool_points){0};
    stp_scene* scene = NULL;
    stp_spill* spill = NULL;
    stp_placed_part* parts = NULL;
    size_t part_count = 0;
    stp_result result = STP_OK;
    if (beside != NULL && may_be_large(context, path)) {
        result = tool_points_open_spill(context, beside, points);
        result = result == STP_OK ? stp_spill_create_sibling(points->spill, &spill) : result;
    }
    result = result == STP_OK ? tool_import_spilled(context, path, spill, &scene) : result;
    if (result == STP_OK && scene->root == STP_NONE) {
        result = stp_fail(context, STP_ERROR_FORMAT, "%s: expected points, found none", path);
    }
    if (result == STP_OK) {
        result = stp_scene_flatten(scene, scene->root, SIZE_MAX, &parts, &part_count);
    }
    if (result == STP_OK) {
        result = copy_parts(scene, path, parts, part_count, origin, points);
    }
    if (result == STP_OK && triangles) {
        result = copy_triangles(scene, path, parts, part_count, points);
    }
    stp_free(context, parts);
    stp_scene_destroy(scene);
    stp_spill_destroy(spill);
    if (result != STP_OK) {
        tool_points_destroy(context, points);
    }
    return result;
}

stp_result tool_read_points(stp_context* context, const char* path, const double* origin,
                            tool_points* points)
{
    return read_file(context, path, origin, false, NULL, points);
}

int tool_run_on_points(const tool_points_command* task, int argc, char** argv, const char* path,
                       uint64_t threads, uint64_t memory)
{
    if (argc != 1) {
        return tool_usage_error("%s: expected one %s", task->name, task->input);
    }
    if (path == NULL) {
        return tool_usage_error("%s: expected -o %s", task->name, task->output);
    }
    if (strcmp(path, "-") == 0) {
        return tool_usage_error("%s cannot write to standard output; give a file name", task->name);
    }
    int refused = overwrite_check(argv[0], path);
    if (refused != 0) {
        return refused;
    }
    stp_context* context = tool_context_create((uint32_t)threads, memory, NULL);
    if (context == NULL) {
        return 1;
    }
    tool_points points;
    int code = 1;
    const char* beside = task->spills ? path : NULL;
    if (read_file(context, argv[0], NULL, task->triangles, beside, &points) == STP_OK) {
        code = task->work(context, argv[0], &points);
        tool_points_destroy(context, &points);
    }
    stp_context_destroy(context);
    return code;
}

void tool_points_destroy(stp_context* context, tool_points* points)
{
    if (!points->spilled) {
        stp_free(context, points->positions);
        stp_free(context, points->normals);
        stp_free(context, points->colors);
    }
    stp_free(context, points->triangles);
    stp_spill_destroy(points->spill);
    *points = (tool_points){0};
}

size_t tool_put_position(unsigned char* bytes, const float* position, const double* origin,
                         bool doubles)
{
    size_t size = doubles ? 8 : 4;
    for (size_t k = 0; k < 3; ++k) {
        if (doubles) {
            stp_write_f64(bytes + size * k, (double)position[k] + origin[k]);
        } else {
            stp_write_f32(bytes + size * k, position[k]);
        }
    }
    return 3 * size;
}

static stp_result write_header(stp_file_writer* writer, const tool_points* points, uint32_t count,
                               bool doubles)
{
    char text[512];
    const char* type = doubles ? "double" : "float";
    int size = snprintf(
        text, sizeof(text),
        "ply\nformat binary_little_endian 1.0\ncomment ordered by stipple\n"
        "element vertex %u\nproperty %s x\nproperty %s y\nproperty %s z\n%s%send_header\n",
        count, type, type, type,
        points->normals != NULL ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        points->colors != NULL ? "property uchar red\nproperty uchar green\nproperty "
                                 "uchar blue\nproperty uchar alpha\n"
                               : "");
    assert(size > 0 && (size_t)size < sizeof(text) && "the header is not cut off");
    return stp_file_writer_append(writer, text, (size_t)size);
}

static stp_result write_point(stp_file_writer* writer, const tool_points* points, size_t i,
                              bool doubles)
{
    unsigned char bytes[40];
    size_t size = tool_put_position(bytes, points->positions + 3 * i, points->origin, doubles);
    for (size_t k = 0; k < 3 && points->normals != NULL; ++k, size += 4) {
        stp_write_f32(bytes + size, points->normals[3 * i + k]);
    }
    if (points->colors != NULL) {
        memcpy(bytes + size, points->colors + 4 * i, 4);
        size += 4;
    }
    assert(size <= sizeof(bytes));
    return stp_file_writer_append(writer, bytes, size);
}

stp_result tool_write_points(stp_context* context, const char* path, const tool_points* points,
                             const uint32_t* order, uint32_t count)
{
    bool doubles = points->origin[0] != 0.0 || points->origin[1] != 0.0 || points->origin[2] != 0.0;
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result != STP_OK) {
        return result;
    }
    result = write_header(writer, points, count, doubles);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        assert(order[i] < points->count && "an order holds indices of points");
        result = write_point(writer, points, order[i], doubles);
    }
    if (result != STP_OK) {
        stp_file_writer_abort(writer);
        return result;
    }
    return stp_file_writer_commit(writer);
}
