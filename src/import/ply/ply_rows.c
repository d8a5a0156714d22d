// SPDX-License-Identifier: MIT
#include "base/io/bytes.h"
#include "import/ply/ply.h"

#include <assert.h>
#include <math.h>
#include <string.h>

static uint16_t read_u16(const unsigned char* bytes, stp_ply_encoding encoding)
{
    return encoding == STP_PLY_LITTLE ? stp_read_u16(bytes) : (uint16_t)(bytes[0] << 8 | bytes[1]);
}

static uint32_t read_u32(const unsigned char* bytes, stp_ply_encoding encoding)
{
    uint32_t value = stp_read_u32(bytes);
    return encoding == STP_PLY_LITTLE
               ? value
               : value >> 24 | (value >> 8 & 0xff00) | (value << 8 & 0xff0000) | value << 24;
}

double stp_ply_value(const unsigned char* bytes, stp_ply_type type, stp_ply_encoding encoding)
{
    switch (type) {
    case STP_PLY_INT8:
        return (double)(int8_t)bytes[0];
    case STP_PLY_UINT8:
        return (double)bytes[0];
    case STP_PLY_INT16:
        return (double)(int16_t)read_u16(bytes, encoding);
    case STP_PLY_UINT16:
        return (double)read_u16(bytes, encoding);
    case STP_PLY_INT32:
        return (double)(int32_t)read_u32(bytes, encoding);
    case STP_PLY_UINT32:
        return (double)read_u32(bytes, encoding);
    case STP_PLY_FLOAT32: {
        uint32_t bits = read_u32(bytes, encoding);
        float value;
        memcpy(&value, &bits, sizeof(value));
        return (double)value;
    }
    case STP_PLY_FLOAT64:
        break;
    }
    uint64_t low = read_u32(bytes + (encoding == STP_PLY_LITTLE ? 0 : 4), encoding);
    uint64_t bits =
        (uint64_t)read_u32(bytes + (encoding == STP_PLY_LITTLE ? 4 : 0), encoding) << 32 | low;
    double value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

// Lines with values of a text that ends with a line end.
static uint64_t count_lines(stp_text text, stp_text end)
{
    uint64_t lines = 0;
    for (stp_text at = text; at < end; ++at) {
        lines += *stp_skip_blanks(at) != '\n';
        at = memchr(at, '\n', (size_t)(end - at));
    }
    return lines;
}

// Whether there are as many lines as rows: then each is one.
static bool row_is_line(const stp_ply* ply, uint64_t lines)
{
    uint64_t rows = 0;
    for (size_t i = 0; i < ply->element_count; ++i) {
        rows += ply->elements[i].property_count > 0 ? ply->elements[i].count : 0;
    }
    return rows == lines;
}

// Values of a text that ends with a line end.
static uint64_t count_values(stp_text text, stp_text end)
{
    uint64_t values = 0;
    for (stp_text at = text; at < end; ++at) {
        at = stp_skip_blanks(at);
        values += *at != '\n';
        while (*at != '\n' && !stp_is_blank(*at)) {
            at += 1;
        }
    }
    return values;
}

/// A cloud that lacks at most a hundredth of its points, such as of a program that counted wrong,
/// has those that are there.
static void accept_missing_points(stp_ply* ply, const stp_ply_cursor* cursor, uint64_t lines)
{
    stp_ply_element* only = NULL;
    for (size_t i = 0; i < ply->element_count; ++i) {
        stp_ply_element* e = &ply->elements[i];
        if (e->count > 0 && (only != NULL || e->has_lists || strcmp(e->name, "vertex") != 0)) {
            return;
        }
        only = e->count > 0 ? e : only;
    }
    if (only == NULL || only->property_count == 0) {
        return;
    }
    uint64_t there = only->count;
    if (cursor->text == NULL) {
        there = (uint64_t)(cursor->end - cursor->at) / only->row_size;
    } else if (lines < only->count) { // rows may share a line; the file may end within one
        there = count_values(cursor->at, cursor->end) / only->property_count;
    }
    if (there < only->count && only->count - there <= only->count / 100) {
        stp_warn(ply->context, "%s: %llu of %llu points are missing: the file ends before them",
                 ply->import->path, (unsigned long long)(only->count - there),
                 (unsigned long long)only->count);
        only->count = there;
    }
}

stp_result stp_ply_cursor_open(stp_ply* ply, stp_ply_cursor* cursor)
{
    const stp_mapped_file* file = &ply->import->file;
    size_t size = file->size - ply->body;
    assert(ply->body <= file->size);
    *cursor = (stp_ply_cursor){
        .ply = ply, .at = file->bytes + ply->body, .end = file->bytes + file->size};
    uint64_t lines = 0;
    if (ply->encoding == STP_PLY_ASCII) {
        cursor->text = stp_alloc(ply->context, size + 1);
        if (cursor->text == NULL) {
            return stp_fail_memory(ply->context);
        }
        memcpy(cursor->text, cursor->at, size);
        cursor->text[size] = '\n';
        cursor->at = cursor->text;
        cursor->end = cursor->text + size + 1;
        lines = count_lines(cursor->at, cursor->end);
    }
    accept_missing_points(ply, cursor, lines);
    cursor->row_is_line = cursor->text != NULL && row_is_line(ply, lines);
    return STP_OK;
}

void stp_ply_cursor_close(stp_ply_cursor* cursor)
{
    stp_free(cursor->ply->context, cursor->text);
    cursor->text = NULL;
}

stp_result stp_ply_check_rows(const stp_ply_cursor* cursor, const stp_ply_element* element)
{
    // each value of a text takes at least two bytes, a digit and a separator
    size_t minimum =
        cursor->ply->encoding == STP_PLY_ASCII ? 2 * element->property_count : element->row_size;
    size_t left = (size_t)(cursor->end - cursor->at);
    if (minimum != 0 && element->count > left / minimum) {
        return stp_fail(cursor->ply->context, STP_ERROR_TRUNCATED,
                        "%s: element %.60s: the header says %llu rows, but the file is too short",
                        cursor->ply->import->path, element->name,
                        (unsigned long long)element->count);
    }
    return STP_OK;
}

bool stp_ply_next(stp_ply_cursor* cursor, stp_ply_type type, double* value)
{
    assert(cursor->at <= cursor->end);
    assert(cursor->text == NULL || cursor->end[-1] == '\n');
    if (cursor->text == NULL) {
        size_t size = stp_ply_type_size(type);
        if ((size_t)(cursor->end - cursor->at) < size) {
            return false;
        }
        *value = stp_ply_value(cursor->at, type, cursor->ply->encoding);
        cursor->at += size;
        return true;
    }
    stp_text at = cursor->at;
    for (;; ++at) {
        at = stp_skip_blanks(at);
        if (*at != '\n') {
            break;
        }
        if (at + 1 >= cursor->end) {
            cursor->at = cursor->end;
            return false;
        }
    }
    cursor->at = at;
    at = stp_read_number(at, value);
    if (at == NULL || (!stp_is_blank(*at) && *at != '\n')) {
        return false;
    }
    cursor->at = at;
    return true;
}

bool stp_ply_next_list(stp_ply_cursor* cursor, const stp_ply_property* property, uint64_t* length)
{
    assert(property->is_list && property->count_type < STP_PLY_FLOAT32);
    double count;
    if (!stp_ply_next(cursor, property->count_type, &count) || !(count >= 0.0)) {
        return false;
    }
    size_t left = (size_t)(cursor->end - cursor->at);
    size_t minimum = cursor->text != NULL ? 2 : stp_ply_type_size(property->type);
    if (count > (double)(left / minimum)) {
        cursor->at = cursor->end;
        return false;
    }
    *length = (uint64_t)count;
    return true;
}

bool stp_ply_skip(stp_ply_cursor* cursor, const stp_ply_property* property)
{
    uint64_t count = 1;
    if (property->is_list && !stp_ply_next_list(cursor, property, &count)) {
        return false;
    }
    double value;
    if (cursor->text == NULL && property->is_list) {
        cursor->at += count * stp_ply_type_size(property->type); // was checked
        assert(cursor->at <= cursor->end);
        return true;
    }
    for (; count > 0; --count) {
        if (!stp_ply_next(cursor, property->type, &value)) {
            return false;
        }
    }
    return true;
}

void stp_ply_end_row(stp_ply_cursor* cursor)
{
    if (!cursor->row_is_line || cursor->at >= cursor->end) {
        return;
    }
    stp_text at = stp_skip_blanks(cursor->at);
    cursor->long_rows += *at != '\n';
    cursor->at = memchr(at, '\n', (size_t)(cursor->end - at));
    assert(cursor->at != NULL && "the text ends with a line end");
}

stp_result stp_ply_fail_row(const stp_ply_cursor* cursor, const stp_ply_element* element,
                            uint64_t row)
{
    assert(row < element->count);
    const char* path = cursor->ply->import->path;
    bool ended = cursor->at >= cursor->end || cursor->text == NULL;
    return ended ? stp_fail(cursor->ply->context, STP_ERROR_TRUNCATED,
                            "%s: element %.60s: the file ends within row %llu of %llu", path,
                            element->name, (unsigned long long)row + 1,
                            (unsigned long long)element->count)
                 : stp_fail(cursor->ply->context, STP_ERROR_FORMAT,
                            "%s: element %.60s: row %llu has a value that is not a number", path,
                            element->name, (unsigned long long)row + 1);
}
