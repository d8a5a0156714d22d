// SPDX-License-Identifier: MIT
// Reads the PLY files that splat_file.c writes.
#include "base/io/bytes.h"
#include "base/io/file.h"
#include "program/files/splat_file.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum {
    X,
    Y,
    Z,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    AXIS_X,
    AXIS_Y,
    AXIS_Z,
    MINOR,
    RED,
    GREEN,
    BLUE,
    SLOTS,
    HEADER_MAX = 65536,
    MAX_LINE = 256,
};

static const char* const slot_names[SLOTS] = {
    "x", "y", "z", "nx", "ny", "nz", "axis_x", "axis_y", "axis_z", "minor", "red", "green", "blue"};

typedef struct value_type {
    const char *name, *other;
    size_t size;
} value_type;

static const value_type value_types[] = {
    {"float", "float32", 4}, {"double", "float64", 8}, {"uchar", "uint8", 1}, {"char", "int8", 1},
    {"short", "int16", 2},   {"ushort", "uint16", 2},  {"int", "int32", 4},   {"uint", "uint32", 4},
};
enum { FLOAT, DOUBLE, UCHAR, TYPES = sizeof(value_types) / sizeof(value_types[0]) };

/// A column of the file.
typedef struct slot {
    bool there;
    int type;
    size_t offset; ///< within a row
} slot;

typedef struct reader {
    stp_context* context;
    const char* path;
    stp_mapped_file file;
    size_t body; ///< where rows begin
    size_t row_size;
    uint64_t count;
    slot slots[SLOTS];
} reader;

bool tool_is_splat_file(const char* path)
{
    char head[4096 + 1];
    size_t size = stp_file_peek(path, head, sizeof(head) - 1);
    head[size] = '\0';
    return strncmp(head, "ply\n", 4) == 0 && strstr(head, " axis_x\n") != NULL;
}

static stp_result refuse(const reader* r, const char* what)
{
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: expected splats as decimate writes them: %s",
                    r->path, what);
}

static int find_type(const char* name)
{
    for (int i = 0; i < (int)TYPES; ++i) {
        if (strcmp(name, value_types[i].name) == 0 || strcmp(name, value_types[i].other) == 0) {
            return i;
        }
    }
    return -1;
}

static stp_result add_property(reader* r, const char* type_name, const char* name)
{
    int type = find_type(type_name);
    if (type < 0) {
        return refuse(r, "a property has a type of unknown size");
    }
    for (int k = 0; k < SLOTS; ++k) {
        if (strcmp(name, slot_names[k]) == 0) {
            r->slots[k] = (slot){true, type, r->row_size};
        }
    }
    r->row_size += value_types[type].size;
    return STP_OK;
}

// Takes one line of the header.
// @param ends set after the last line
static stp_result read_line(reader* r, const char* line, int* elements, bool* ends)
{
    char first[32] = "", second[64] = "", third[64] = "";
    unsigned long long count = 0;
    int words = sscanf(line, "%31s %63s %63s", first, second, third);
    if (strcmp(first, "end_header") == 0) {
        *ends = true;
    } else if (strcmp(first, "format") == 0 && strcmp(second, "binary_little_endian") != 0) {
        return refuse(r, "its values are not binary, little-endian");
    } else if (strcmp(first, "element") == 0) {
        *elements += 1;
        bool splats = *elements == 1 && strcmp(second, "vertex") == 0;
        if (splats && sscanf(third, "%llu", &count) == 1) {
            r->count = count;
        } else {
            return refuse(r, "it should have one element, vertex");
        }
    } else if (strcmp(first, "property") == 0) {
        return words == 3 && *elements == 1 ? add_property(r, second, third)
                                            : refuse(r, "a property cannot be read");
    }
    return STP_OK;
}

static stp_result read_header(reader* r)
{
    size_t limit = r->file.size < HEADER_MAX ? r->file.size : HEADER_MAX, at = 0;
    int elements = 0;
    bool ends = false;
    while (!ends) {
        char line[MAX_LINE];
        const unsigned char* bytes = r->file.bytes + at;
        const unsigned char* end = at < limit ? memchr(bytes, '\n', limit - at) : NULL;
        if (end == NULL || (size_t)(end - bytes) >= sizeof(line)) {
            return refuse(r, "its header does not end");
        }
        memcpy(line, bytes, (size_t)(end - bytes));
        line[end - bytes] = '\0';
        at += (size_t)(end - bytes) + 1;
        stp_result result = read_line(r, line, &elements, &ends);
        if (result != STP_OK) {
            return result;
        }
    }
    r->body = at;
    for (int k = 0; k < SLOTS; ++k) {
        bool number = r->slots[k].type == FLOAT || (r->slots[k].type == DOUBLE && k <= Z);
        if (k < RED && (!r->slots[k].there || !number)) {
            return refuse(r, "a property is missing or is not a number of its type");
        }
    }
    assert(r->row_size > 0 && "the required properties have a size");
    if (r->count == 0 || r->count > UINT32_MAX || r->count > (r->file.size - at) / r->row_size) {
        return refuse(r, "its size does not match its header, or it is empty");
    }
    return STP_OK;
}

static double value_of(const reader* r, const unsigned char* row, int k)
{
    const unsigned char* at = row + r->slots[k].offset;
    return r->slots[k].type == DOUBLE ? stp_read_f64(at) : (double)stp_read_f32(at);
}

static stp_vec3 vector_of(const reader* r, const unsigned char* row, int k)
{
    return (stp_vec3){(float)value_of(r, row, k), (float)value_of(r, row, k + 1),
                      (float)value_of(r, row, k + 2)};
}

static bool read_row(const reader* r, const unsigned char* row, const double origin[3],
                     stp_ellipse* e, uint8_t* color)
{
    e->center = (stp_vec3){(float)(value_of(r, row, X) - origin[0]),
                           (float)(value_of(r, row, Y) - origin[1]),
                           (float)(value_of(r, row, Z) - origin[2])};
    e->normal = stp_normalize(vector_of(r, row, NORMAL_X));
    e->major = vector_of(r, row, AXIS_X);
    e->minor = (float)value_of(r, row, MINOR);
    for (int k = 0; k < 3; ++k) {
        bool given = r->slots[RED + k].there && r->slots[RED + k].type == UCHAR;
        color[k] = given ? row[r->slots[RED + k].offset] : 255;
    }
    return stp_is_finite(e->center) && stp_is_finite(e->major) && e->minor >= 0.0f &&
           isfinite(e->minor);
}

static stp_result read_rows(const reader* r, tool_splat_set* splats)
{
    const unsigned char* rows = r->file.bytes + r->body;
    splats->ellipses = STP_NEW_ARRAY(r->context, stp_ellipse, (size_t)r->count);
    splats->colors = STP_NEW_ARRAY(r->context, uint8_t, 3 * (size_t)r->count);
    if (splats->ellipses == NULL || splats->colors == NULL) {
        return stp_fail_memory(r->context);
    }
    for (int k = 0; k < 3; ++k) { // floats would lose digits far away
        double first = value_of(r, rows, X + k);
        splats->origin[k] = r->slots[X + k].type == DOUBLE && isfinite(first) ? first : 0.0;
    }
    for (uint32_t i = 0; i < (uint32_t)r->count; ++i) {
        if (!read_row(r, rows + r->row_size * i, splats->origin, &splats->ellipses[i],
                      splats->colors + 3 * (size_t)i)) {
            return stp_fail(r->context, STP_ERROR_FORMAT,
                            "%s: splat %u has a position or size that is not finite", r->path, i);
        }
    }
    splats->count = (uint32_t)r->count;
    return STP_OK;
}

stp_result tool_read_splats(stp_context* context, const char* path, tool_splat_set* splats)
{
    reader r = {.context = context, .path = path};
    *splats = (tool_splat_set){0};
    stp_result result = stp_file_map(context, path, &r.file);
    if (result != STP_OK) {
        return result;
    }
    result = read_header(&r);
    result = result == STP_OK ? read_rows(&r, splats) : result;
    stp_file_unmap(&r.file);
    if (result != STP_OK) {
        tool_splat_set_destroy(context, splats);
    }
    return result;
}

void tool_splat_set_destroy(stp_context* context, tool_splat_set* splats)
{
    stp_free(context, splats->ellipses);
    stp_free(context, splats->colors);
    *splats = (tool_splat_set){0};
}
