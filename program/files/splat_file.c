// SPDX-License-Identifier: MIT
#include "program/files/splat_file.h"

#include "base/io/bytes.h"
#include "base/io/file.h"
#include "program/files/point_file.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static stp_result write_header(stp_file_writer* writer, uint32_t count, const char* type)
{
    char text[768];
    int size = snprintf(text, sizeof(text),
                        "ply\nformat binary_little_endian 1.0\ncomment splats by stipple\n"
                        "element vertex %u\nproperty %s x\nproperty %s y\nproperty %s z\n"
                        "property float nx\nproperty float ny\nproperty float nz\n"
                        "property float axis_x\nproperty float axis_y\nproperty float axis_z\n"
                        "property float minor\n"
                        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                        "end_header\n",
                        count, type, type, type);
    return stp_file_writer_append(writer, text, (size_t)size);
}

static size_t put_vector(unsigned char* bytes, stp_vec3 v)
{
    stp_write_f32(bytes, v.x);
    stp_write_f32(bytes + 4, v.y);
    stp_write_f32(bytes + 8, v.z);
    return 12;
}

static stp_result write_splat(stp_file_writer* writer, const tool_splats* s, size_t index,
                              bool doubles)
{
    unsigned char bytes[64];
    const stp_ellipse* e = &s->ellipses[index];
    const float center[3] = {e->center.x, e->center.y, e->center.z};
    size_t size = tool_put_position(bytes, center, s->origin, doubles);
    size += put_vector(bytes + size, e->normal);
    size += put_vector(bytes + size, e->major);
    assert(size + 7 <= sizeof(bytes));
    stp_write_f32(bytes + size, e->minor);
    memcpy(bytes + size + 4, s->colors + 3 * index, 3);
    return stp_file_writer_append(writer, bytes, size + 7);
}

stp_result tool_write_splats(stp_context* context, const char* path, const tool_splats* splats)
{
    const double* o = splats->origin;
    bool doubles = o[0] != 0.0 || o[1] != 0.0 || o[2] != 0.0;
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result != STP_OK) {
        return result;
    }
    result = write_header(writer, splats->count, doubles ? "double" : "float");
    for (uint32_t i = 0; i < splats->count && result == STP_OK; ++i) {
        result = write_splat(writer, splats, splats->indices[i], doubles);
    }
    if (result != STP_OK) {
        stp_file_writer_abort(writer);
        return result;
    }
    return stp_file_writer_commit(writer);
}
