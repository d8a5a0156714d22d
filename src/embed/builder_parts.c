// SPDX-License-Identifier: MIT
// Copies the caller's meshes and points, and converts them to scene conventions: unit normals,
// linear colours of meshes, finite numbers.
#include "base/math/color.h"
#include "embed/builder.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/// Copies an array; NULL if there is none, or if out of memory, which sets *failed.
static void* copy_array(stp_context* context, const void* from, size_t count, size_t size,
                        bool* failed)
{
    void* copy = from != NULL && !*failed ? stp_alloc_array(context, count, size) : NULL;
    *failed = *failed || (from != NULL && copy == NULL);
    return copy != NULL ? memcpy(copy, from, count * size) : NULL;
}

/// Normalizes; zero stays zero.
static void normalize(float* normals, size_t count)
{
    for (size_t i = 0; normals != NULL && i < count; ++i) {
        float* n = normals + 3 * i;
        double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                             (double)n[2] * (double)n[2]);
        double factor = isfinite(length) && length > 0.0 ? 1.0 / length : 0.0;
        for (int k = 0; k < 3; ++k) {
            n[k] = factor > 0.0 ? (float)(factor * (double)n[k]) : 0.0f;
        }
    }
}

static void make_finite(float* values, size_t count)
{
    for (size_t i = 0; values != NULL && i < count; ++i) {
        values[i] = isfinite(values[i]) ? values[i] : 0.0f;
    }
}

/// sRGB and alpha, 8 bits, to linear and alpha, 16 bits. NULL if there is none, or if out of
/// memory.
static uint16_t* linear_colors(stp_context* context, const uint8_t* colors, size_t count,
                               bool* failed)
{
    uint16_t table[256];
    uint16_t* linear =
        colors != NULL && !*failed ? stp_alloc_array(context, count, 4 * sizeof(uint16_t)) : NULL;
    *failed = *failed || (colors != NULL && linear == NULL);
    for (int i = 0; i < 256; ++i) {
        table[i] = (uint16_t)(stp_srgb8_to_linear((uint8_t)i) * 65535.0f + 0.5f);
    }
    for (size_t i = 0; linear != NULL && i < 4 * count; ++i) {
        linear[i] = i % 4 == 3 ? (uint16_t)(257u * colors[i]) : table[colors[i]];
    }
    return linear;
}

static stp_result note_part(stp_builder* builder, stp_part_kind kind, uint32_t index,
                            uint32_t* part)
{
    assert(index < (kind == STP_PART_MESH ? builder->staged->mesh_count
                                          : builder->staged->point_set_count));
    if (!STP_MAKE_ROOM(builder->context, builder->parts, builder->part_capacity,
                       builder->part_count + 1)) {
        return stp_fail_memory(builder->context);
    }
    builder->parts[builder->part_count++] = (stp_part){.kind = kind, .index = index};
    if (part != NULL) {
        *part = (uint32_t)builder->part_count;
    }
    return STP_OK;
}

static stp_result check_mesh(const stp_builder* builder, const stp_mesh_desc* d)
{
    const char* fault = NULL;
    if (d->positions == NULL || d->vertex_count == 0 || d->triangle_count == 0) {
        fault = "no triangles";
    } else if (d->vertex_count >= STP_NONE || d->triangle_count >= STP_NONE / 3) {
        fault = "too many vertices or triangles for one mesh";
    } else if (d->indices == NULL && d->vertex_count / 3 < d->triangle_count) {
        fault = "fewer vertices than its triangles have";
    }
    for (size_t i = 0; fault == NULL && d->indices != NULL && i < 3 * d->triangle_count; ++i) {
        fault = d->indices[i] < d->vertex_count ? NULL : "an index is not below vertex_count";
    }
    return fault == NULL
               ? STP_OK
               : stp_fail(builder->context, STP_ERROR_ARGUMENT, "stp_mesh_desc: %s", fault);
}

static uint32_t* copy_indices(stp_context* context, const stp_mesh_desc* d, bool* failed)
{
    assert(d->triangle_count < STP_NONE / 3 && "more do not fit the indices");
    size_t count = 3 * d->triangle_count;
    if (d->indices != NULL) {
        return copy_array(context, d->indices, count, sizeof(uint32_t), failed);
    }
    uint32_t* indices = *failed ? NULL : STP_NEW_ARRAY(context, uint32_t, count);
    *failed = *failed || indices == NULL;
    for (size_t i = 0; indices != NULL && i < count; ++i) {
        indices[i] = (uint32_t)i;
    }
    return indices;
}

stp_result stp_builder_add_mesh(stp_builder* builder, const stp_mesh_desc* given, uint32_t* part)
{
    stp_mesh_desc d = {0};
    stp_result result = stp_builder_check(builder, 0);
    if (result == STP_OK) {
        result = STP_READ_DESC(builder->context, stp_mesh_desc, &d, given);
    }
    result = result == STP_OK ? stp_builder_check(builder, d.material) : result;
    result = result == STP_OK ? check_mesh(builder, &d) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_context* context = builder->context;
    bool failed = false;
    size_t vertices = d.vertex_count;
    stp_mesh mesh = {
        .name = d.name,
        .vertex_count = (uint32_t)vertices,
        .triangle_count = (uint32_t)d.triangle_count,
        .material = d.material + STP_BUILDER_MATERIAL,
        .positions = copy_array(context, d.positions, vertices, 3 * sizeof(float), &failed),
    };
    mesh.normals = copy_array(context, d.normals, vertices, 3 * sizeof(float), &failed);
    mesh.texcoords[0] = copy_array(context, d.texcoords, vertices, 2 * sizeof(float), &failed);
    mesh.colors = linear_colors(context, d.colors, vertices, &failed);
    mesh.indices = copy_indices(context, &d, &failed);
    if (failed) {
        stp_free(context, mesh.positions);
        stp_free(context, mesh.normals);
        stp_free(context, mesh.texcoords[0]);
        stp_free(context, mesh.colors);
        stp_free(context, mesh.indices);
        return stp_fail_memory(context);
    }
    normalize(mesh.normals, vertices);
    make_finite(mesh.texcoords[0], 2 * vertices);
    uint32_t index = 0;
    result = stp_scene_add_mesh(builder->staged, &mesh, &index);
    return result == STP_OK ? note_part(builder, STP_PART_MESH, index, part) : result;
}

static void free_points(stp_context* context, const stp_point_set* points)
{
    stp_free(context, points->positions);
    stp_free(context, points->normals);
    stp_free(context, points->colors);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        stp_free(context, points->attributes[i]);
    }
}

static void limit_times(double* times, size_t count)
{
    for (size_t i = 0; times != NULL && i < count; ++i) {
        times[i] = fabs(times[i]) <= STP_SCENE_TIME_LIMIT ? times[i] : 0.0;
    }
}

stp_result stp_builder_add_points(stp_builder* builder, const stp_points_desc* given,
                                  uint32_t* part)
{
    stp_points_desc d = {0};
    stp_result result = stp_builder_check(builder, 0);
    if (result == STP_OK) {
        result = STP_READ_DESC(builder->context, stp_points_desc, &d, given);
    }
    result = result == STP_OK ? stp_builder_check(builder, d.material) : result;
    if (result != STP_OK) {
        return result;
    }
    stp_context* context = builder->context;
    if (d.positions == NULL || d.point_count == 0 || d.point_count >= STP_NONE) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "stp_points_desc: no points, or too many for one set");
    }
    bool failed = false;
    size_t count = d.point_count;
    stp_point_set points = {
        .name = d.name,
        .point_count = (uint32_t)count,
        .material = d.material + STP_BUILDER_MATERIAL,
        .positions = copy_array(context, d.positions, count, 3 * sizeof(float), &failed),
    };
    points.normals = copy_array(context, d.normals, count, 3 * sizeof(float), &failed);
    points.colors = copy_array(context, d.colors, count, 4, &failed);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        points.attributes[i] = copy_array(context, d.attributes[i], count,
                                          stp_attribute_size((stp_attribute)i), &failed);
    }
    if (failed) {
        free_points(context, &points);
        return stp_fail_memory(context);
    }
    normalize(points.normals, count);
    limit_times(points.attributes[STP_ATTRIBUTE_TIME], count);
    uint32_t index = 0;
    result = stp_scene_add_point_set(builder->staged, &points, &index);
    return result == STP_OK ? note_part(builder, STP_PART_POINTS, index, part) : result;
}
