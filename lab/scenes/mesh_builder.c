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

static bool make_vertex_room(mesh_builder* b, size_t needed)
{
    size_t before = b->vertex_capacity, capacities[] = {before, before, before}; // grow alike
    bool made = stp_make_room(b->context, &b->positions, &capacities[0], needed, 3 * sizeof(float));
    made = made && (b->flat || stp_make_room(b->context, &b->normals, &capacities[1], needed,
                                             3 * sizeof(float)));
    made = made && (!b->colored || stp_make_room(b->context, &b->colors, &capacities[2], needed,
                                                 4 * sizeof(uint16_t)));
    b->vertex_capacity = made ? capacities[0] : before;
    return made;
}

bool mesh_builder_make_room(mesh_builder* builder, size_t vertices, size_t indices)
{
    size_t needed = builder->vertex_count + vertices;
    builder->failed = builder->failed ||
                      (needed > builder->vertex_capacity && !make_vertex_room(builder, needed)) ||
                      !STP_MAKE_ROOM(builder->context, builder->indices, builder->index_capacity,
                                     builder->index_count + indices);
    return !builder->failed;
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
    if (!mesh_builder_make_room(builder, 1, 0)) {
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
    if (!mesh_builder_make_room(builder, 0, 3)) {
        return;
    }
    uint32_t* corner = builder->indices + builder->index_count;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    builder->index_count += 3;
}
