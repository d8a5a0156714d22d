// SPDX-License-Identifier: MIT
#include "scenes/mesh_builder.h"

void mesh_builder_init(mesh_builder* builder, stp_context* context)
{
    *builder = (mesh_builder){.context = context, .place = stp_affine_identity()};
}

void mesh_builder_destroy(mesh_builder* builder)
{
    stp_free(builder->context, builder->positions);
    stp_free(builder->context, builder->normals);
    stp_free(builder->context, builder->indices);
    *builder = (mesh_builder){.context = builder->context};
}

// Room for one more vertex in both arrays, which grow alike.
static bool grow_vertices(mesh_builder* builder)
{
    size_t capacity = builder->vertex_capacity, needed = builder->vertex_count + 1;
    float* positions =
        stp_grow_array(builder->context, builder->positions, &capacity, needed, 3 * sizeof(float));
    if (positions == NULL) {
        return false;
    }
    builder->positions = positions;
    capacity = builder->vertex_capacity;
    float* normals =
        stp_grow_array(builder->context, builder->normals, &capacity, needed, 3 * sizeof(float));
    if (normals == NULL) {
        return false;
    }
    builder->normals = normals;
    builder->vertex_capacity = capacity;
    return true;
}

uint32_t mesh_builder_vertex(mesh_builder* builder, stp_vec3 position, stp_vec3 normal)
{
    if (builder->failed ||
        (builder->vertex_count == builder->vertex_capacity && !grow_vertices(builder))) {
        builder->failed = true;
        return 0;
    }
    const stp_affine* a = &builder->place;
    double p[3] = {(double)position.x, (double)position.y, (double)position.z};
    double n[3] = {(double)normal.x, (double)normal.y, (double)normal.z};
    double moved[3], turned[3], square = 0.0;
    for (int row = 0; row < 3; ++row) {
        const double* m = a->m[row];
        moved[row] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
        turned[row] = m[0] * n[0] + m[1] * n[1] + m[2] * n[2];
        square += turned[row] * turned[row];
    }
    double scale = square > 0.0 ? 1.0 / sqrt(square) : 0.0;
    size_t at = 3 * builder->vertex_count;
    for (int axis = 0; axis < 3; ++axis) {
        builder->positions[at + (size_t)axis] = (float)moved[axis];
        builder->normals[at + (size_t)axis] = (float)(turned[axis] * scale);
    }
    return (uint32_t)builder->vertex_count++;
}

void mesh_builder_triangle(mesh_builder* builder, uint32_t a, uint32_t b, uint32_t c)
{
    if (builder->failed) {
        return;
    }
    if (builder->index_count + 3 > builder->index_capacity) {
        uint32_t* indices =
            stp_grow_array(builder->context, builder->indices, &builder->index_capacity,
                           builder->index_count + 3, sizeof(uint32_t));
        if (indices == NULL) {
            builder->failed = true;
            return;
        }
        builder->indices = indices;
    }
    uint32_t* corner = builder->indices + builder->index_count;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    builder->index_count += 3;
}
