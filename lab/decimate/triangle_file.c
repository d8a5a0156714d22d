// SPDX-License-Identifier: MIT
#include "base/io/bytes.h"
#include "base/io/file.h"
#include "lab/decimate/decimators.h"
#include "program/files/point_file.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static stp_result write_header(stp_file_writer* writer, const tool_triangles* t, const char* type)
{
    char text[512];
    int size = snprintf(text, sizeof(text),
                        "ply\nformat binary_little_endian 1.0\ncomment triangles by stipple\n"
                        "element vertex %u\nproperty %s x\nproperty %s y\nproperty %s z\n"
                        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                        "element face %u\nproperty list uchar uint vertex_indices\nend_header\n",
                        t->vertex_count, type, type, type, t->triangle_count);
    return stp_file_writer_append(writer, text, (size_t)size);
}

static stp_result write_vertex(stp_file_writer* writer, const tool_triangles* t, size_t index,
                               bool doubles)
{
    unsigned char bytes[32];
    size_t size = tool_put_position(bytes, t->vertices + 3 * index, t->origin, doubles);
    memcpy(bytes + size, t->colors + 3 * index, 3);
    return stp_file_writer_append(writer, bytes, size + 3);
}

static stp_result write_triangle(stp_file_writer* writer, const uint32_t* triangle)
{
    unsigned char bytes[13] = {3};
    for (size_t k = 0; k < 3; ++k) {
        stp_write_u32(bytes + 1 + 4 * k, triangle[k]);
    }
    return stp_file_writer_append(writer, bytes, sizeof(bytes));
}

stp_result tool_write_triangles(stp_context* context, const char* path, const tool_triangles* t)
{
    bool doubles = t->origin[0] != 0.0 || t->origin[1] != 0.0 || t->origin[2] != 0.0;
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result != STP_OK) {
        return result;
    }
    result = write_header(writer, t, doubles ? "double" : "float");
    for (uint32_t i = 0; i < t->vertex_count && result == STP_OK; ++i) {
        result = write_vertex(writer, t, i, doubles);
    }
    for (uint32_t i = 0; i < t->triangle_count && result == STP_OK; ++i) {
        const uint32_t* corners = t->triangles + 3 * (size_t)i;
        assert(corners[0] < t->vertex_count && corners[1] < t->vertex_count &&
               corners[2] < t->vertex_count);
        result = write_triangle(writer, corners);
    }
    if (result != STP_OK) {
        stp_file_writer_abort(writer);
        return result;
    }
    return stp_file_writer_commit(writer);
}
