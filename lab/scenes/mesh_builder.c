// SPDX-License-Identifier: MIT
#include "lab/scenes/mesh_builder.h"

#include <assert.h>
#include <string.h>

void mesh_builder_init(mesh_builder* builder, stp_context* context)
{
    *builder = (mesh_builder){.context = context, .place = stp_affine_identity()};
}

void mesh_builder_destroy(mesh_builder* builder)
{
    stp_free(builder->context, builder->positions);
    stp_free(builder->context, builder->normals);
    stp_free(builder->context, builder->colors);
    stp_free(builder->context, builder->indices);
    *builder = (mesh_builder){.context = builder->context};
}

// Grows one vertex array for one more vertex; all arrays grow alike. NULL if out of memory.
static void* grow_array(const mesh_builder* builder, void* array, size_t size, size_t* capacity)
{
    *capacity = builder->vertex_capacity;
    return stp_grow_array(builder->context, array, capacity, builder->vertex_count + 1, size);
}

static bool grow_vertices(mesh_builder* builder)
{
    size_t capacity;
    float* positions = grow_array(builder, builder->positions, 3 * sizeof(float), &capacity);
    if (positions == NULL) {
        return false;
    }
    builder->positions = positions;
    if (!builder->flat) {
        float* normals = grow_array(builder, builder->normals, 3 * sizeof(float), &capacity);
        if (normals == NULL) {
            return false;
        }
        builder->normals = normals;
    }
    if (builder->colored) {
        uint16_t* colors = grow_array(builder, builder->colors, 4 * sizeof(uint16_t), &capacity);
        if (colors == NULL) {
            return false;
        }
        builder->colors = colors;
    }
    builder->vertex_capacity = capacity;
    return true;
}

static uint16_t color_value(double value)
{
    return (uint16_t)(value <= 0.0 ? 0.0 : value >= 1.0 ? 65535.0 : value * 65535.0 + 0.5);
}

void mesh_builder_color(mesh_builder* builder, double red, double green, double blue)
{
    assert(builder->colored || builder->vertex_count == 0);
    builder->colored = true;
    builder->color[0] = color_value(red);
    builder->color[1] = color_value(green);
    builder->color[2] = color_value(blue);
    builder->color[3] = UINT16_MAX;
}

static void put_normal(mesh_builder* builder, stp_vec3 normal)
{
    double n[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    double turned[3], square = 0.0;
    for (int row = 0; row < 3; ++row) {
        const double* m = builder->place.m[row];
        turned[row] = m[0] * n[0] + m[1] * n[1] + m[2] * n[2];
        square += turned[row] * turned[row];
    }
    double scale = square > 0.0 ? 1.0 / sqrt(square) : 0.0;
    float* out = builder->normals + 3 * builder->vertex_count;
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = (float)(turned[axis] * scale);
    }
}

uint32_t mesh_builder_vertex(mesh_builder* builder, stp_vec3 position, stp_vec3 normal)
{
    if (builder->counting) {
        return (uint32_t)builder->vertex_count++;
    }
    if (builder->failed ||
        (builder->vertex_count == builder->vertex_capacity && !grow_vertices(builder))) {
        builder->failed = true;
        return 0;
    }
    stp_vec3d moved = stp_affine_point(&builder->place, stp_to_double(position));
    float* out = builder->positions + 3 * builder->vertex_count;
    out[0] = (float)moved.x;
    out[1] = (float)moved.y;
    out[2] = (float)moved.z;
    if (!builder->flat) {
        put_normal(builder, normal);
    }
    if (builder->colored) {
        memcpy(builder->colors + 4 * builder->vertex_count, builder->color, sizeof(builder->color));
    }
    return (uint32_t)builder->vertex_count++;
}

void mesh_builder_triangle(mesh_builder* builder, uint32_t a, uint32_t b, uint32_t c)
{
    if (builder->failed || builder->counting) {
        builder->index_count += 3;
        return;
    }
    if (builder->index_count + 3 > builder->index_capacity) {
        if (!STP_MAKE_ROOM(builder->context, builder->indices, builder->index_capacity,
                           builder->index_count + 3)) {
            builder->failed = true;
            return;
        }
    }
    uint32_t* corner = builder->indices + builder->index_count;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    builder->index_count += 3;
}
