// SPDX-License-Identifier: MIT
// Converts faces and triangle strips of a PLY file to triangles.
#include "import/ply/ply.h"
#include "import/reading/triangulate.h"

#include <assert.h>
#include <string.h>

bool stp_ply_is_one_of(const char* name, const char* words)
{
    size_t length = strlen(name);
    while (*words != '\0') {
        size_t word = strcspn(words, " ");
        if (word == length && memcmp(words, name, length) == 0) {
            return true;
        }
        words += word + (words[word] == ' ');
    }
    return false;
}

static const stp_ply_property* find_indices(const stp_ply_element* element)
{
    for (size_t i = 0; i < element->property_count; ++i) {
        const stp_ply_property* property = &element->properties[i];
        if (property->is_list &&
            stp_ply_is_one_of(property->name, "vertex_indices vertex_index vertex_indexes")) {
            return property;
        }
    }
    return NULL;
}

// Reads a list of vertex indices; -1 (strip restart) becomes STP_NONE where it is allowed.
static stp_result read_corners(stp_ply_cursor* cursor, const stp_ply_element* element,
                               const stp_ply_property* property, uint64_t row, size_t vertex_count,
                               bool strips, stp_ply_faces* f, uint64_t* count)
{
    stp_context* context = cursor->ply->context;
    if (!stp_ply_next_list(cursor, property, count)) {
        return stp_ply_fail_row(cursor, element, row);
    }
    if (!STP_MAKE_ROOM(context, f->corners, f->corner_capacity, (size_t)*count)) {
        return stp_fail_memory(context);
    }
    assert(*count <= f->corner_capacity);
    for (uint64_t i = 0; i < *count; ++i) {
        double value;
        if (!stp_ply_next(cursor, property->type, &value)) {
            return stp_ply_fail_row(cursor, element, row);
        }
        if (strips && value == -1.0) {
            f->corners[i] = STP_NONE;
        } else if (value >= 0.0 && value < (double)vertex_count) {
            f->corners[i] = (uint32_t)value;
        } else {
            return stp_fail(
                context, STP_ERROR_FORMAT,
                "%s: element %.60s: row %llu refers to vertex %.17g (the file has %llu)",
                cursor->ply->import->path, element->name, (unsigned long long)row + 1, value,
                (unsigned long long)vertex_count);
        }
    }
    return STP_OK;
}

static uint32_t* add_triangles(stp_context* context, stp_ply_faces* f, size_t triangles)
{
    if (!STP_MAKE_ROOM(context, f->indices, f->capacity, f->count + 3 * triangles)) {
        (void)stp_fail_memory(context);
        return NULL;
    }
    f->count += 3 * triangles;
    assert(f->count % 3 == 0 && f->count <= f->capacity);
    return f->indices + f->count - 3 * triangles;
}

static stp_result add_strip(stp_context* context, stp_ply_faces* f, size_t count)
{
    uint32_t* out = add_triangles(context, f, count);
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    size_t start = 0, written = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t* c = f->corners + i;
        if (c[0] == STP_NONE) {
            start = i + 1;
        } else if (i >= start + 2) {
            bool odd = ((i - start) & 1) != 0; // every other triangle of a strip is reversed
            out[written++] = odd ? c[-1] : c[-2];
            out[written++] = odd ? c[-2] : c[-1];
            out[written++] = c[0];
        }
    }
    assert(written <= 3 * count && written % 3 == 0);
    f->count -= 3 * count - written;
    return STP_OK;
}

static stp_result add_face(stp_context* context, const float* positions, stp_ply_faces* f,
                           size_t count)
{
    if (count < 3) {
        f->small += 1;
        return STP_OK;
    }
    if (f->wedges.active) {
        return stp_ply_wedges_add(&f->wedges, positions, f->corners, count);
    }
    uint32_t* out = add_triangles(context, f, count - 2);
    if (out == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    bool good = stp_triangulate(context, positions, f->corners, (uint32_t)count, out);
    return good ? STP_OK : stp_fail_memory(context);
}

// Reads a row. @return with *count corners
static stp_result read_row(stp_ply_cursor* cursor, const stp_ply_element* element,
                           const stp_ply_property* indices, uint64_t row, size_t vertex_count,
                           bool strips, stp_ply_faces* f, uint64_t* count)
{
    stp_result result = STP_OK;
    stp_ply_wedges_begin_face(&f->wedges);
    for (size_t i = 0; i < element->property_count && result == STP_OK; ++i) {
        const stp_ply_property* property = &element->properties[i];
        bool good = true;
        if (property == indices) {
            result = read_corners(cursor, element, property, row, vertex_count, strips, f, count);
        } else if (f->wedges.active && !strips) {
            result = stp_ply_wedges_read(&f->wedges, cursor, property, &good);
        } else {
            good = stp_ply_skip(cursor, property);
        }
        result = good ? result : stp_ply_fail_row(cursor, element, row);
    }
    stp_ply_end_row(cursor);
    return result;
}

stp_result stp_ply_read_faces(stp_ply_cursor* cursor, const stp_ply_element* element, bool strips,
                              const float* positions, size_t vertex_count, stp_ply_faces* f)
{
    stp_context* context = cursor->ply->context;
    const stp_ply_property* indices = find_indices(element);
    bool wedges = f->wedges.active && !strips;
    f->any |= indices != NULL && element->count > 0;
    if (wedges) {
        stp_ply_wedges_begin_element(&f->wedges, element);
    }
    for (uint64_t row = 0; row < element->count; ++row) {
        uint64_t count = 0;
        stp_result result =
            read_row(cursor, element, indices, row, vertex_count, strips, f, &count);
        if (result == STP_OK && indices != NULL) {
            result = strips ? add_strip(context, f, (size_t)count)
                            : add_face(context, positions, f, (size_t)count);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    if (wedges) {
        stp_ply_wedges_end_element(&f->wedges);
    }
    if (f->count / 3 >= STP_NONE) {
        return stp_fail(context, STP_ERROR_LIMIT, "%s: has more than 2^32 triangles",
                        cursor->ply->import->path);
    }
    return STP_OK;
}
